// Statistics with plots, legends of views, the list of keys.

#include "apps/pieview/panel.h"
#include "osgPlugins/osgpie/view_switch.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <array>

namespace pieview {
namespace {

using pie::engine::View;

void row(const char* name, const std::string& value) {
    ImGui::TextDisabled("%s", name);
    ImGui::SameLine(ImGui::GetFontSize() * 9);
    ImGui::TextUnformatted(value.c_str());
}

std::string megabytes(std::size_t bytes) { return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1048576.0); }

/// 2.46 M; short enough for the panel.
std::string brief(std::uint64_t count) {
    const auto value = static_cast<double>(count);
    if (count >= 1'000'000) return fmt::format("{:.2f} M", value / 1e6);
    return count >= 10'000 ? fmt::format("{:.0f} k", value / 1e3) : fmt::format("{}", count);
}

ImU32 packed(const Rgb& colour) {
    const Rgb c = colour * 255.0F;
    return IM_COL32(static_cast<int>(c.x), static_cast<int>(c.y), static_cast<int>(c.z), 255);
}

/// As the program does it (view_program.cpp): blue, near white, red.
Rgb differenceColour(float d) {
    const Rgb far = d > 0 ? Rgb(0.70F, 0.05F, 0.10F) : Rgb(0.05F, 0.20F, 0.70F);
    return Rgb(0.93F) + (far - Rgb(0.93F)) * std::min(1.0F, std::abs(d));
}

} // namespace

void drawStatistics(Session& session) {
    if (!session.level()) return;
    const pie::engine::Statistics s = session.level()->engine().statistics();
    const StageTimes& times = session.times();
    for (std::size_t stage = 0; stage < StageTimes::names.size(); ++stage) {
        const std::vector<float> values = times.of(stage);
        const std::string latest = fmt::format("{:.2f} ms", times.latest(stage));
        const float most = values.empty() ? 1.0F : *std::max_element(values.begin(), values.end());
        ImGui::PlotLines(std::string(StageTimes::names.at(stage)).c_str(), values.data(),
                         static_cast<int>(values.size()), 0, latest.c_str(), 0, std::max(1.0F, most),
                         {ImGui::GetFontSize() * 13, ImGui::GetFontSize() * (stage == 0 ? 3.0F : 1.8F)});
    }
    row("read in", fmt::format("{:.2f} s", session.loadMilliseconds() / 1000));
    row("photons", fmt::format("{} emitted, {} kept", brief(s.photonsEmitted), brief(s.photonsInMap)));
    row("estimates", fmt::format("{} made, {} reused", brief(s.estimatesMade), brief(s.estimatesReused)));
    row("unfinished", fmt::format("{} of {} vertices", s.unfinished, s.receivers));
    row("triangles", fmt::format("{} drawn, {} coarse", s.drawnTriangles, s.coarseTriangles));
    row("lights", fmt::format("{}", s.lights));
    if (s.errorPercent >= 0) row("error", fmt::format("{:.2f} %", s.errorPercent));
    row("memory", fmt::format("{} in all", megabytes(s.sceneBytes + s.intersectorBytes + s.mapBytes + s.receiverBytes +
                                                     s.estimatorBytes + s.directBytes)));
    row("  estimator", megabytes(s.estimatorBytes));
    row("  receivers", megabytes(s.receiverBytes));
    row("  direct light", megabytes(s.directBytes));
    row("  scene, rays", megabytes(s.sceneBytes + s.intersectorBytes));
}

void drawLegend(Session& session) {
    const View view = session.looks().view;
    if ((view != View::Difference && view != View::Samples) || !session.level()) return;
    constexpr int steps = 64;
    const float font = ImGui::GetFontSize();
    const ImVec2 screen = ImGui::GetMainViewport()->Size;
    const float width = std::min(font * 22, screen.x * 0.6F);
    const ImVec2 at(font * 1.5F, screen.y - font * 5.5F);
    ImDrawList& list = *ImGui::GetForegroundDrawList();
    list.AddRectFilled({at.x - 10, at.y - 6}, {at.x + width + 10, at.y + font * 2.6F}, IM_COL32(0, 0, 0, 190), 4);
    const bool difference = view == View::Difference;
    const auto most = static_cast<float>(osgpie::largestSampleCount(session.level()->engine().settings()));
    for (int i = 0; i < steps; ++i) {
        const float t = (static_cast<float>(i) + 0.5F) / steps;
        const Rgb colour = difference ? differenceColour(2 * t - 1)
                                      : osgpie::sampleColour(std::exp2(t * std::log2(1 + most)) - 1, most);
        list.AddRectFilled({at.x + width * static_cast<float>(i) / steps, at.y},
                           {at.x + width * static_cast<float>(i + 1) / steps + 1, at.y + font}, packed(colour));
    }
    const std::array<std::string, 3> labels =
        difference ? std::array<std::string, 3>{"-64 U", "same", "+64 U, ours brighter"}
                   : std::array<std::string, 3>{"0 rays", fmt::format("{:.0f}", std::sqrt(1 + most) - 1),
                                                fmt::format("{:.0f}", most)};
    for (std::size_t i = 0; i < labels.size(); ++i) {
        const float textWidth = ImGui::CalcTextSize(labels.at(i).c_str()).x;
        const float x = at.x + (width - textWidth) * static_cast<float>(i) / 2;
        list.AddText({x, at.y + font * 1.2F}, IM_COL32(230, 230, 230, 255), labels.at(i).c_str());
    }
}

void drawKeys(Session& session) {
    const ImVec2 screen = ImGui::GetMainViewport()->Size;
    const float font = ImGui::GetFontSize();
    ImGui::SetNextWindowPos({screen.x * 0.5F, screen.y * 0.5F}, ImGuiCond_Always, {0.5F, 0.5F});
    ImGui::SetNextWindowSize({std::min(screen.x - 16, font * 84), std::min(screen.y - 16, font * 46)});
    ImGui::SetNextWindowBgAlpha(0.97F);
    ImGui::SetNextWindowFocus();
    bool open = true;
    ImGui::Begin("Keys", &open, ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse);
    if (ImGui::BeginTable("groups", 3, ImGuiTableFlags_SizingStretchSame)) {
        std::string_view group;
        for (const Binding& binding : bindings()) {
            if (binding.group != group) {
                if (binding.group != "Window") ImGui::TableNextColumn();
                group = binding.group;
                ImGui::Spacing();
                ImGui::TextColored({1.0F, 0.8F, 0.4F, 1.0F}, "%s", std::string(group).c_str());
            }
            const float start = ImGui::GetCursorPosX();
            const float end = start + ImGui::GetContentRegionAvail().x;
            ImGui::TextUnformatted(std::string(binding.keys).c_str());
            ImGui::SameLine(0, font * 0.7F);
            ImGui::SetCursorPosX(std::max(ImGui::GetCursorPosX(), start + font * 6.5F));
            ImGui::PushTextWrapPos(end);
            ImGui::TextDisabled("%s", std::string(binding.what).c_str());
            ImGui::PopTextWrapPos();
        }
        ImGui::EndTable();
    }
    ImGui::End();
    if (!open) session.looks().help = false;
}

} // namespace pieview
