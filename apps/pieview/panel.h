#pragma once
// What is drawn over the level: the panel with its controls, marks of lights, legends, the error of a broken save, the
// list of keys. Controls change the session as their keys do.

#include "apps/pieview/session.h"
#include "apps/support/camera.h"

namespace pieview {

struct PanelPlace {
    apps::Lens lens;          ///< of the picture beneath
    float scale = 1;          ///< of text, from the screen's resolution
    float pixelsPerPoint = 1; ///< of the picture
};

/// Once, after ImGui has a context.
void styleForPanel(float scale);
/// Between ImGui::NewFrame() and Render().
void drawPanel(Session& session, const PanelPlace& place);

/// Parts of it, in sources of their own.
void drawLightMarks(Session& session, const PanelPlace& place);
void drawLightControls(Session& session);
void drawStatistics(Session& session);
void drawKeys(Session& session);
void drawLegend(Session& session);

} // namespace pieview
