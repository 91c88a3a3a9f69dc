#include <fmt/format.h>
#include <imgui.h>

#include "turgor/window/panels.hpp"

namespace turgor {

namespace {

const ImVec4 kBad{1.0f, 0.45f, 0.35f, 1}, kGood{0.75f, 0.9f, 0.75f, 1}, kPlain{0.8f, 0.82f, 0.85f, 1};

void line(const std::string& text, ImVec4 color = kPlain) {
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
  return fmt::format("{}, {:.2f} × real time (frame {}, display {})", when, now.real_pace,
                     milliseconds(now.frame_seconds), milliseconds(now.show_seconds));
}

std::string haptics_text(const SessionStatus& now) {
  const haptics::TimingReport& t = now.haptics;
  return fmt::format("haptics {:.0f} ticks/s, {} of {} missed, tick {:.0f} µs (99th percentile)", t.rate,
                     t.missed, t.ticks + t.missed, 1e6 * t.compute.p99);
}

}  // namespace

void show_status(const Viewer& viewer) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({8, size.y - 8}, ImGuiCond_Always, {0, 1});
  ImGui::SetNextWindowSize({size.x - 16, 0});
  ImGui::SetNextWindowBgAlpha(0.55f);
  const ImGuiWindowFlags flags =
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings;
  if (!ImGui::Begin("status", nullptr, flags)) return ImGui::End();
  const SessionStatus& now = *viewer.now;
  if (now.phase == SessionStatus::Phase::kLoading)
    line(now.done > 0 ? fmt::format("{} … {:.0f} %", now.doing, 100 * now.done) : now.doing + " …", kGood);
  else if (now.phase == SessionStatus::Phase::kReady)
    line(fmt::format("{}   |   {}   |   {:.0f} pictures/s", physics_text(now),
                     now.is_haptic ? haptics_text(now) : std::string("no haptics"), viewer.drawn_per_second));
  if (!now.error.empty()) line(now.error, kBad);
  if (!viewer.message.empty()) line(viewer.message, kGood);
  if (now.phase == SessionStatus::Phase::kFailed) line("R reloads the scene file, ? shows the keys");
  ImGui::End();
}

}  // namespace turgor
