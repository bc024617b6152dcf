// Lights: the list, the controls of the chosen one, marks in the view.

#include "apps/pieview/panel.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <set>

namespace pieview {
namespace {

const char* strengthName(const Light& light) {
    if (std::holds_alternative<pie::lights::AreaLight>(light)) return "radiosity U";
    const bool parallel =
        std::holds_alternative<pie::lights::SunLight>(light) || std::holds_alternative<pie::lights::SkyLight>(light);
    return parallel ? "irradiance U" : "light";
}

ImU32 colourFor(const Light& light, int alpha) {
    const Rgb c = glm::clamp(colourOf(light), Rgb(0.0F), Rgb(1.0F)) * 255.0F;
    return IM_COL32(static_cast<int>(c.x), static_cast<int>(c.y), static_cast<int>(c.z), alpha);
}

void drawChosen(Session& session, std::size_t number) {
    LightEdits& lights = session.lights();
    Light light = lights.light(number);
    bool on = lights.isOn(number);
    ImGui::PushID(static_cast<int>(number));
    if (ImGui::Checkbox("on", &on)) lights.setOn(number, on);
    ImGui::SameLine();
    ImGui::Text("%zu  %s", number, session.groupOf(number).c_str());
    Rgb colour = colourOf(light);
    if (ImGui::ColorEdit3("colour", &colour.x, ImGuiColorEditFlags_Float))
        lights.set(number, withColour(light, colour));
    float strength = strengthOf(light);
    const float speed = std::max(0.5F, strength * 0.01F);
    if (ImGui::DragFloat(strengthName(light), &strength, speed, 0, 1e7F, "%.0f"))
        lights.set(number, withStrength(light, strength));
    if (auto position = positionOf(light)) {
        if (ImGui::DragFloat3("place", &position->x, 1, 0, 0, "%.0f")) lights.set(number, movedTo(light, *position));
        if (ImGui::SmallButton("go there")) session.run(Command::GoToLight);
        ImGui::SameLine();
    }
    if (ImGui::SmallButton("this group")) session.run(Command::SwitchGroup);
    if (lights.isEdited(number)) {
        ImGui::SameLine();
        if (ImGui::SmallButton("undo")) session.run(Command::UndoLight);
    }
    ImGui::PopID();
}

void drawGroup(Session& session, const std::string& group) {
    LightEdits& lights = session.lights();
    std::size_t count = 0;
    bool anyOn = false;
    for (std::size_t i = 0; i < lights.size(); ++i)
        if (session.groupOf(i) == group) {
            ++count;
            anyOn = anyOn || lights.isOn(i);
        }
    ImGui::PushID(group.c_str());
    if (ImGui::Checkbox("##group", &anyOn)) session.switchGroup(group, anyOn);
    ImGui::SameLine();
    const bool open = ImGui::TreeNode("lights", "%zu  %s", count, group.c_str());
    if (open) {
        for (std::size_t i = 0; i < lights.size(); ++i) {
            if (session.groupOf(i) != group) continue;
            const Light& light = lights.light(i);
            const auto position = positionOf(light);
            const std::string place =
                position ? fmt::format("({:.0f} {:.0f} {:.0f})", position->x, position->y, position->z) : "";
            const std::string label = fmt::format("{}{} {}  {:.0f} {}", lights.isOn(i) ? "" : "off ", i, place,
                                                  strengthOf(light), lights.isEdited(i) ? "*" : "");
            ImGui::PushStyleColor(ImGuiCol_Text, colourFor(light, lights.isOn(i) ? 255 : 120));
            if (ImGui::Selectable(label.c_str(), session.selected() == i)) session.select(i);
            ImGui::PopStyleColor();
        }
        ImGui::TreePop();
    }
    ImGui::PopID();
}

} // namespace

void drawLightControls(Session& session) {
    LightEdits& lights = session.lights();
    bool icons = session.looks().lightIcons;
    if (ImGui::Checkbox("show in the view", &icons)) session.run(Command::LightIcons);
    ImGui::SameLine();
    ImGui::TextDisabled("%zu, %zu edited", lights.size(), lights.edits().size());
    if (!lights.edits().empty()) {
        ImGui::SameLine();
        if (ImGui::SmallButton("save")) session.run(Command::SaveLights);
    }
    if (session.selected()) {
        ImGui::Separator();
        drawChosen(session, *session.selected());
        ImGui::Separator();
    }
    if (!ImGui::TreeNode("list")) return;
    std::set<std::string> groups;
    for (std::size_t i = 0; i < lights.size(); ++i) groups.insert(session.groupOf(i));
    ImGui::BeginChild("groups", {0, ImGui::GetFontSize() * 14});
    for (const std::string& group : groups) drawGroup(session, group);
    ImGui::EndChild();
    if (ImGui::SmallButton("all on")) session.run(Command::AllLightsOn);
    ImGui::SameLine();
    if (ImGui::SmallButton("undo all")) session.run(Command::UndoLights);
    ImGui::TreePop();
}

void drawLightMarks(Session& session, const PanelPlace& place) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const LightEdits& lights = session.lights();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const Light& light = lights.light(i);
        const auto position = positionOf(light);
        if (!position) continue;
        const auto pixel = apps::pixelOf(session.camera(), place.lens, *position);
        if (!pixel) continue;
        const bool chosen = session.selected() == i;
        const bool hidden = !chosen && session.hidden(*position);
        const float distance = glm::length(*position - session.camera().eye);
        const float radius = place.scale * std::clamp(1500.0F / std::max(1.0F, distance), 3.5F, 8.0F);
        const ImVec2 at(pixel->x / place.pixelsPerPoint, pixel->y / place.pixelsPerPoint);
        const int alpha = hidden ? 60 : 230;
        if (lights.isOn(i))
            list.AddCircleFilled(at, radius, colourFor(light, alpha));
        else
            list.AddLine({at.x - radius, at.y - radius}, {at.x + radius, at.y + radius}, IM_COL32(255, 90, 70, alpha));
        list.AddCircle(at, radius + 1, IM_COL32(0, 0, 0, alpha), 0, 1.5F);
        if (lights.isEdited(i)) list.AddCircle(at, radius + 3, IM_COL32(255, 200, 60, alpha), 0, 1.5F);
        if (chosen) list.AddCircle(at, radius + 6 * place.scale, IM_COL32(255, 255, 255, 255), 0, 2);
    }
}

} // namespace pieview
