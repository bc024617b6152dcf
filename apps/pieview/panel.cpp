#include "apps/pieview/panel.h"

#include <fmt/format.h>
#include <imgui.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace pieview {
namespace {

using pie::engine::View;

struct NamedView {
    View view;
    Command command;
    const char* name;
};
constexpr std::array<NamedView, 12> views{{
    {View::Lit, Command::ViewLit, "lit"},
    {View::Light, Command::ViewLight, "light alone"},
    {View::Fullbright, Command::ViewFullbright, "textures alone"},
    {View::Baked, Command::ViewBaked, "baked"},
    {View::Lightmap, Command::ViewLightmap, "lightmaps alone"},
    {View::Split, Command::ViewSplit, "baked | lit"},
    {View::Difference, Command::ViewDifference, "difference"},
    {View::Normals, Command::ViewNormals, "normals"},
    {View::Triangles, Command::ViewTriangles, "triangles"},
    {View::CoarseTriangles, Command::ViewCoarseTriangles, "coarse triangles"},
    {View::Photons, Command::ViewPhotons, "photons"},
    {View::Samples, Command::ViewSamples, "samples"},
}};

void tip(Command command) {
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(keysOf(command)).c_str());
}

bool button(Session& session, const char* name, Command command) {
    const bool pressed = ImGui::Button(name);
    tip(command);
    if (pressed) session.run(command);
    return pressed;
}

void choice(Session& session, const char* name, bool chosen, Command command) {
    if (ImGui::RadioButton(name, chosen)) session.run(command);
    tip(command);
}

void toggle(Session& session, const char* name, bool on, Command command) {
    if (ImGui::Checkbox(name, &on)) session.run(command);
    tip(command);
}

void drawViewControls(Session& session) {
    Looks& looks = session.looks();
    const char* shown = "";
    for (const NamedView& view : views)
        if (view.view == looks.view) shown = view.name;
    if (ImGui::BeginCombo("view", shown)) {
        for (const NamedView& view : views) {
            const std::string label = fmt::format("{}  [{}]", view.name, keysOf(view.command));
            if (ImGui::Selectable(label.c_str(), view.view == looks.view)) session.run(view.command);
        }
        ImGui::EndCombo();
    }
    if (looks.view == View::Split) ImGui::SliderFloat("divider", &looks.split, -1, 1, "");
    ImGui::SliderFloat("exposure", &looks.exposure, 0.05F, 20, "%.2f", ImGuiSliderFlags_Logarithmic);
    tip(Command::Brighter);
    toggle(session, "flashlight", looks.flashlight, Command::Flashlight);
    ImGui::SameLine();
    toggle(session, "time runs", looks.timeRuns, Command::Time);
    const auto& settings = session.settings();
    ImGui::AlignTextToFramePadding();
    ImGui::Text("brightest %g x texture,", static_cast<double>(settings.overbrightClamp));
    ImGui::SameLine();
    button(session, "change##overbright", Command::Overbright);
    ImGui::AlignTextToFramePadding();
    ImGui::Text("colours %s,", settings.value("color_space").c_str());
    ImGui::SameLine();
    button(session, "change##space", Command::ColorSpace);
}

void drawCameraControls(Session& session) {
    choice(session, "fly", session.motion() == Motion::Fly, Command::Fly);
    ImGui::SameLine();
    choice(session, "walk", session.motion() == Motion::Walk, Command::Walk);
    ImGui::SameLine();
    choice(session, "orbit", session.motion() == Motion::Orbit, Command::Orbit);
    const std::string place = apps::cameraText(session.camera());
    ImGui::TextUnformatted(place.c_str());
    ImGui::SameLine();
    if (ImGui::SmallButton("copy")) ImGui::SetClipboardText(place.c_str());
    button(session, "next start", Command::NextStart);
    ImGui::SameLine();
    ImGui::Text("%.0f units/s", static_cast<double>(session.speed()));
    ImGui::TextUnformatted("bookmarks");
    for (int digit = 0; digit < 10; ++digit) {
        const bool set = session.notes().bookmarks.at(static_cast<std::size_t>(digit)).has_value();
        if (digit != 5) ImGui::SameLine();
        if (digit == 5) ImGui::Dummy({ImGui::CalcTextSize("bookmarks").x, 0}), ImGui::SameLine();
        if (!set) ImGui::PushStyleColor(ImGuiCol_Button, IM_COL32(50, 50, 50, 120));
        if (ImGui::SmallButton(fmt::format(" {} ", digit).c_str()))
            session.run(ImGui::GetIO().KeyCtrl || !set ? Command::SetBookmark : Command::GoToBookmark, digit);
        if (!set) ImGui::PopStyleColor();
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip(set ? "%d goes there, Ctrl+%d sets it anew" : "%d: Ctrl+%d sets it", digit, digit);
    }
    ImGui::Text("path: %zu places", session.notes().path.size());
    ImGui::SameLine();
    button(session, "add", Command::AddPathKey);
    ImGui::SameLine();
    button(session, session.playing() ? "stop" : "play", Command::PlayPath);
    ImGui::SameLine();
    button(session, "forget", Command::ClearPath);
}

/// A setting that needs the level to be read again, taken when Enter is pressed.
void drawSetting(Session& session, const char* key) {
    static std::string editedKey;
    static std::string edited;
    std::string value = editedKey == key ? edited : session.settings().value(key);
    if (ImGui::InputText(key, &value, ImGuiInputTextFlags_EnterReturnsTrue)) {
        if (const auto error = session.change(key, value)) session.say(error->message());
        editedKey.clear();
    } else if (ImGui::IsItemActive()) {
        editedKey = key;
        edited = value;
    } else if (editedKey == key) {
        editedKey.clear();
    }
    if (!ImGui::IsItemHovered()) return;
    for (const auto& info : pie::engine::describe())
        if (info.key == key) {
            ImGui::BeginTooltip();
            ImGui::PushTextWrapPos(ImGui::GetFontSize() * 26);
            ImGui::TextUnformatted(std::string(info.consequence).c_str());
            ImGui::PopTextWrapPos();
            ImGui::EndTooltip();
        }
}

void drawSettings(Session& session) {
    ImGui::TextDisabled("Enter reads the level again");
    for (const char* key : {"preset", "budget_ms", "target_error", "photons_from_light", "gather_rays", "max_edge",
                            "light_scale", "reflectance"})
        drawSetting(session, key);
}

void drawState(Session& session) {
    ImGui::TextUnformatted(std::filesystem::path(session.levelName()).filename().string().c_str());
    ImGui::SameLine();
    if (session.loading())
        ImGui::TextColored({1.0F, 0.8F, 0.3F, 1.0F}, "reading ...");
    else if (!session.error().empty())
        ImGui::TextColored({1.0F, 0.4F, 0.3F, 1.0F}, "broken");
    else if (session.settled())
        ImGui::TextColored({0.5F, 0.9F, 0.5F, 1.0F}, "settled");
    else
        ImGui::TextColored({1.0F, 0.8F, 0.3F, 1.0F}, "light arrives");
    button(session, "read again", Command::Reload);
    ImGui::SameLine();
    if (session.loading())
        button(session, "give up", Command::Cancel);
    else
        button(session, "picture", Command::Screenshot);
    ImGui::SameLine();
    button(session, "keys ?", Command::Help);
}

void drawList(const char* title, const std::vector<std::string>& lines) {
    if (lines.empty()) return;
    constexpr std::size_t most = 25;
    ImGui::TextColored({1.0F, 0.8F, 0.3F, 1.0F}, "%zu %s", lines.size(), title);
    if (!ImGui::IsItemHovered()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(ImGui::GetFontSize() * 40);
    for (std::size_t i = 0; i < std::min(most, lines.size()); ++i) ImGui::TextUnformatted(lines[i].c_str());
    if (lines.size() > most) ImGui::TextDisabled("and %zu more; bspinfo lists them", lines.size() - most);
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

/// What the level's author should know about its content.
void drawWarnings(Session& session) {
    if (!session.level()) return;
    const auto& statistics = session.level()->level().statistics;
    drawList("warnings", statistics.warnings);
    drawList("textures not found", statistics.missingTextures);
}

void drawBanner(const Session& session) {
    if (session.error().empty()) return;
    const ImGuiViewport& screen = *ImGui::GetMainViewport();
    const float width = screen.Size.x * 0.55F;
    ImGui::SetNextWindowPos({screen.Size.x * 0.02F, screen.Size.y * 0.02F});
    ImGui::SetNextWindowSize({width, 0});
    ImGui::PushStyleColor(ImGuiCol_WindowBg, IM_COL32(120, 20, 15, 235));
    ImGui::Begin("error", nullptr, ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs);
    ImGui::TextWrapped("%s", session.error().c_str());
    ImGui::TextDisabled("shown is the level as it was before; the next save is read at once");
    ImGui::End();
    ImGui::PopStyleColor();
}

void drawNote(Session& session) {
    std::string text = session.note();
    if (!session.level() && session.loading()) text = fmt::format("reading {} ...", session.levelName());
    if (!session.looks().panel && text.empty()) return;
    if (text.empty()) return;
    ImDrawList& list = *ImGui::GetForegroundDrawList();
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const float margin = ImGui::GetFontSize();
    const ImVec2 at(margin, ImGui::GetMainViewport()->Size.y - margin - size.y);
    list.AddRectFilled({at.x - 8, at.y - 5}, {at.x + size.x + 8, at.y + size.y + 5}, IM_COL32(0, 0, 0, 190), 4);
    list.AddText(at, IM_COL32(240, 240, 240, 255), text.c_str());
}

} // namespace

void styleForPanel(float scale) {
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = style.FrameRounding = style.GrabRounding = 3;
    style.WindowBorderSize = 0;
    style.Colors[ImGuiCol_WindowBg] = ImVec4(0.07F, 0.07F, 0.08F, 0.90F);
    style.ScaleAllSizes(scale);
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr; // nothing of the panel is kept
    constexpr const char* font = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
    std::error_code error;
    if (std::filesystem::exists(font, error)) {
        io.Fonts->AddFontFromFileTTF(font, 14 * scale);
    } else {
        ImFontConfig config;
        config.SizePixels = 13 * scale;
        io.Fonts->AddFontDefault(&config);
    }
}

void drawPanel(Session& session, const PanelPlace& place) {
    if (session.looks().lightIcons && session.level()) drawLightMarks(session, place);
    drawLegend(session);
    drawBanner(session);
    drawNote(session);
    if (session.looks().help) drawKeys(session);
    if (!session.looks().panel) return;
    const ImGuiViewport& screen = *ImGui::GetMainViewport();
    const float width = ImGui::GetFontSize() * 22;
    ImGui::SetNextWindowPos({screen.Size.x - width - 8, 8});
    ImGui::SetNextWindowSizeConstraints({width, 0}, {width, screen.Size.y - 16});
    ImGui::Begin("pieview", nullptr,
                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoNavInputs);
    ImGui::PushItemWidth(ImGui::GetFontSize() * 11);
    drawState(session);
    drawWarnings(session);
    if (ImGui::CollapsingHeader("View", ImGuiTreeNodeFlags_DefaultOpen)) drawViewControls(session);
    if (ImGui::CollapsingHeader("Camera")) drawCameraControls(session);
    if (ImGui::CollapsingHeader("Lights", ImGuiTreeNodeFlags_DefaultOpen)) drawLightControls(session);
    if (ImGui::CollapsingHeader("Speed and accuracy")) drawSettings(session);
    ImGui::SetNextItemOpen(session.looks().statistics);
    session.looks().statistics = ImGui::CollapsingHeader("Statistics");
    tip(Command::Statistics);
    if (session.looks().statistics) drawStatistics(session);
    ImGui::PopItemWidth();
    ImGui::End();
}

} // namespace pieview
