#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/appearance.hpp"
#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

void line(const std::string& text, ImVec4 color) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

std::string milliseconds(double seconds) {
  return seconds < 0.01 ? fmt::format("{:.2f} ms", 1e3 * seconds) : fmt::format("{:.0f} ms", 1e3 * seconds);
}

std::string physics_text(const SessionStatus& now) {
  const std::string when = fmt::format("{:.2f} s", now.snapshot.time);
  if (!now.plays) return when + ", paused";
  return fmt::format("{}, {:.2f} × real time\n(frame {}, display {})", when, now.real_pace,
                     milliseconds(now.frame_seconds), milliseconds(now.show_seconds));
}

std::string haptics_text(const SessionStatus& now) {
  const haptics::TimingReport& t = now.haptics;
  return fmt::format("haptics {:.0f} ticks/s, {} of {} missed, tick {:.0f} µs (99th percentile)", t.rate,
                     t.missed, t.ticks + t.missed, 1e6 * t.compute.p99);
}

/// True if the clock is far ahead of the simulation.
bool is_slow(const SessionStatus& now) {
  return now.plays && now.snapshot.frame > 30 && now.real_pace < 0.5 * now.pace;
}

void show_loading(const SessionStatus& now) {
  if (now.done <= 0) return line(now.doing + " …", plain_color());
  ImGui::Text("%s: %.0f %%", now.doing.c_str(), 100 * now.done);
  ImGui::SameLine(14 * ImGui::GetFontSize());
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 0.25f * ImGui::GetTextLineHeight());
  ImGui::ProgressBar(float(now.done), {-1, 0.5f * ImGui::GetTextLineHeight()}, "");
}

/// Rates, times and notes.
void show_details(const Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  ImGui::SetNextWindowSizeConstraints({28 * ImGui::GetFontSize(), 0}, {60 * ImGui::GetFontSize(), 1e6f});
  if (!ImGui::BeginPopup("details")) return;
  if (now.phase == SessionStatus::Phase::kReady) {
    line("physics: " + physics_text(now), plain_color());
    line(now.is_haptic ? haptics_text(now) : std::string("no haptics"), plain_color());
    line(fmt::format("display: {:.0f} pictures/s", viewer.drawn_per_second), plain_color());
    for (const std::string& note : now.notes) line("note: " + note, plain_color());
  }
  if (!now.error.empty()) line(now.error, failure_color());
  if (now.phase == SessionStatus::Phase::kFailed)
    line("R reloads the scene file, Ctrl+O opens another one", plain_color());
  ImGui::EndPopup();
}

}  // namespace

StatusWord status_word(const Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  switch (now.phase) {
    case SessionStatus::Phase::kEmpty:
      return {"Empty"};
    case SessionStatus::Phase::kLoading:
      return {"Loading"};
    case SessionStatus::Phase::kFailed:
      return {"Failed", true};
    case SessionStatus::Phase::kReady:
      break;
  }
  if (!now.error.empty()) return {now.plays ? "Refused" : "Failed", true};
  if (!now.plays) return {"Paused"};
  if (now.cut_result.cut >= 0 && now.cut_result.done < 1) return {"Cutting"};
  return {is_slow(now) ? "Slow" : "Running"};
}

void show_status(Viewer& viewer) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const auto left = float(viewer.area.x);
  ImGui::SetNextWindowPos({left, size.y}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSize({size.x - left, 0});
  constexpr ImGuiWindowFlags kFlags =
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings;
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, ImVec2{8, 4});
  if (ImGui::Begin("status", nullptr, kFlags)) {
    const SessionStatus& now = *viewer.now;
    const StatusWord word = status_word(viewer);
    ImGui::PushStyleColor(ImGuiCol_Text, word.is_failure ? failure_color() : plain_color());
    if (ImGui::SmallButton((word.text + "##status").c_str())) ImGui::OpenPopup("details");
    ImGui::PopStyleColor();
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("click for details");
    show_details(viewer);
    ImGui::SameLine();
    const bool is_failure = !viewer.failure.empty() && viewer.message == viewer.failure;
    if (!now.error.empty())
      line(now.error, failure_color());
    else if (now.phase == SessionStatus::Phase::kLoading)
      show_loading(now);
    else if (now.phase == SessionStatus::Phase::kEmpty && viewer.message.empty())
      line("choose a scene, or drop a scene file on the window", plain_color());
    else
      line(viewer.message, is_failure ? failure_color() : plain_color());
    viewer.status_height = double(ImGui::GetWindowHeight());
  }
  ImGui::End();
  ImGui::PopStyleVar();
}

void show_start(Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  const bool waits = now.phase == SessionStatus::Phase::kReady && !now.plays && now.snapshot.frame == 0;
  if (!waits || viewer.shows_gallery || viewer.document.dialog.is_open) return;
  const Area& area = viewer.area;
  ImGui::SetNextWindowPos({float(area.x + 0.5 * area.width), float(area.y + area.height) - 12},
                          ImGuiCond_Always, {0.5f, 1});
  ImGui::SetNextWindowBgAlpha(0.85f);
  constexpr ImGuiWindowFlags kFlags = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                      ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_AlwaysAutoResize;
  if (!ImGui::Begin("start", nullptr, kFlags)) return ImGui::End();
  const float height = 3 * ImGui::GetTextLineHeightWithSpacing();
  if (ImGui::Button("Play", {1.6f * height, height})) act(viewer, "Space");
  ImGui::SameLine();
  ImGui::BeginGroup();
  ImGui::TextUnformatted("The scene is ready and paused: Play or the space bar starts it.");
  ImGui::TextUnformatted("Left button on a body: press it. Shift: grab it. C: cut skin.");
  ImGui::TextUnformatted("Left button beside it, or right button: turn the view. ?: all keys.");
  ImGui::EndGroup();
  ImGui::End();
}

}  // namespace turgor
