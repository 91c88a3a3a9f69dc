// Pictures of bodies under the largest forces of their tools: whole and close up, before and under the force,
// and in colors.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/pictures/outputs.hpp"
#include "turgor/sim/smooth_snapshot.hpp"

namespace turgor {

namespace {

/// The body as a recording restores it, with normals from its triangles, so that replays draw the same.
BodySnapshot as_recorded(const BodySnapshot& pressed) {
  BodySnapshot body = pressed;
  update_vertices(body);
  show_smooth(body);
  return body;
}

/// A body at rest.
BodySnapshot undeformed(const BodySnapshot& body) {
  BodySnapshot rest = body;
  std::fill(rest.displacement.begin(), rest.displacement.end(), Vec3{});
  std::fill(rest.pressure.begin(), rest.pressure.end(), 0.0f);
  update_vertices(rest);
  show_smooth(rest);
  return rest;
}

/// Tool with the largest force.
const ToolSnapshot& pressing_tool(const std::vector<ToolSnapshot>& tools) {
  return *std::max_element(tools.begin(), tools.end(), [](const ToolSnapshot& a, const ToolSnapshot& b) {
    return norm(a.force) < norm(b.force);
  });
}

/// Outward normal of the surface at rest around a position; zero if no triangle is within reach.
Vec3d outward_around(const BodySnapshot& body, Vec3d position, double reach) {
  Vec3d sum;
  for (const Int3 t : body.triangles) {
    const Vec3d a(body.rest[std::size_t(t.x)]), b(body.rest[std::size_t(t.y)]),
        c(body.rest[std::size_t(t.z)]);
    if (norm(a - position) < reach) sum += cross(b - a, c - a);
  }
  return sum;
}

/// View direction for a tool: from the touched surface towards the eye, and the up vector.
struct Aim {
  Vec3d direction, up;
};

/// The side view shows the dent with the tool in it. The view from above is drawn without the tool and shows
/// the surface under it.
Aim aim_at_tool(const BodySnapshot& body, const ToolSnapshot& tool, bool from_above) {
  const Vec3d outward = outward_around(body, tool.pose.position, 2 * tool.size);
  // pulling tools are pulled towards the body; forceps approach from their handles
  const bool pulls = dot(tool.force, outward) < 0;
  const Vec3d out = tool.has_jaws ? tool.pose.axes.column[2] : normalized(pulls ? outward : tool.force);
  const Vec3d head = std::abs(out.z) < 0.9 ? Vec3d{0, 0, 1} : Vec3d{0, -1, 0};
  const Vec3d side = normalized(cross(out, head));
  const Vec3d direction = from_above ? out + side * 0.45 + head * 0.25
                                     : out * (tool.has_jaws ? 0.25 : 0.7) + side * 0.9 + head * 0.55;
  return {direction, out};
}

/// Camera at the contact point of the pressing tool.
Camera camera_at_tool(const ToolSnapshot& tool, const Aim& aim, double reach, double aspect) {
  const Vec3d half{reach, reach, reach};
  return frame_box({tool.pose.position - half, tool.pose.position + half}, aim.direction, aim.up, aspect);
}

constexpr double kArrowFraction = 0.2;  // of a whole body's diagonal

/// Camera of the body with the tool and its arrow: the run's camera, but the side view with the whole handles
/// for forceps, which look like a rod from above.
Camera camera_of_whole(const BodySnapshot& body, const ToolSnapshot& tool, const Aim& aside,
                       const Outputs& outputs, double aspect) {
  Box box = body.box;
  const Vec3d arrow =
      tool.pose.position + normalized(aside.up) * (1.25 * kArrowFraction * norm(box.high - box.low));
  box = joined(box, {arrow, arrow});
  if (tool.has_jaws) box = joined(box, bounding_box(posed_mesh(tool)));
  const Camera& view = outputs.views.front().camera;
  return tool.has_jaws ? frame_box(box, aside.direction, aside.up, aspect)
                       : frame_box(box, view.eye - view.target, view.up, aspect);
}

/// One picture of a body's surface with its tools and forces.
std::optional<Image> draw_body(const BodySnapshot& body, const std::vector<ToolSnapshot>& tools,
                               const Camera& camera, double arrow, Outputs& outputs) {
  PictureItems items;
  add_body(body, SkinColor::kNone, nullptr, items, outputs.scene->look);
  for (const ToolSnapshot& tool : tools) add_tool(tool, {body.typical_force, arrow}, camera.eye, items);
  return draw_items(items, camera, outputs);
}

/// Colored picture without the tools; the scale reaches the largest value unless the scene sets it.
Status add_colored(const BodySnapshot& body, SkinColor color, const char* name, const char* caption,
                   const Camera& camera, Outputs& outputs) {
  const OutputScene& output = outputs.scene->output;
  const std::vector<float> values = shown_values(body, color);
  if (values.empty()) return Done{};  // the body does not have this quantity
  ColorScale scale = color_scale(*outputs.scene, color);
  if (output.color != color || !output.color_range)
    scale.high = *std::max_element(values.begin(), values.end());
  PictureItems items;
  add_body(body, color, &scale, items, outputs.scene->look);
  const std::optional<Image> image = draw_items(items, beside_legend(camera, outputs), outputs);
  if (!image) return Done{};
  return add_picture(outputs, fmt::format("{}-{}.png", body.name, name),
                     fmt::format("{} under the largest force, without the tool: {}", body.name, caption),
                     *image, false);
}

/// Pair before and under the force, side by side.
Status add_pair(const Pressed& pressed, const BodySnapshot& body, const char* name, const char* caption,
                const Camera& camera, double arrow, Outputs& outputs) {
  const auto before = draw_body(undeformed(body), {}, camera, arrow, outputs),
             then = draw_body(body, pressed.tools, camera, arrow, outputs);
  if (!before || !then) return Done{};
  const std::string force =
      fmt::format("{:.3g} N at {:.2f} s", norm(pressing_tool(pressed.tools).force), pressed.time);
  return add_picture(outputs, fmt::format("{}-{}.png", body.name, name),
                     fmt::format("{} {}, before and under the largest force", body.name, caption),
                     side_by_side({*before, *then}, {"before", force}), true);
}

Status add_pictures(const Pressed& pressed, Outputs& outputs) {
  const BodySnapshot body = as_recorded(pressed.body);
  const ToolSnapshot& tool = pressing_tool(pressed.tools);
  const double aspect = double(outputs.scene->output.width) / outputs.scene->output.height;
  const Aim aside = aim_at_tool(body, tool, false), on_top = aim_at_tool(body, tool, true);
  const Camera whole = camera_of_whole(body, tool, aside, outputs, aspect),
               near = camera_at_tool(tool, aside, 0.8 * tool.size, aspect),
               above = camera_at_tool(tool, on_top, 0.7 * tool.size, aspect);
  Status status = add_pair(pressed, body, "near", "from near", near, 0.5 * tool.size, outputs);
  if (status && draws_all(outputs))
    status = add_pair(pressed, body, "whole", "as a whole", whole,
                      kArrowFraction * norm(body.box.high - body.box.low), outputs);
  if (status && draws_all(outputs))
    status = add_colored(body, SkinColor::kDisplacement, "displacement", "displacement", above, outputs);
  if (status && (draws_all(outputs) || outputs.scene->output.color == SkinColor::kPressure))
    status = add_colored(body, SkinColor::kPressure, "pressure", "contact pressure", above, outputs);
  return status;
}

}  // namespace

Status add_pressed_pictures(const std::vector<Pressed>& pressed, Outputs& outputs) {
  for (const Pressed& one : pressed)
    if (one.force > 0 && outputs.can_draw)
      if (const Status status = add_pictures(one, outputs); !status) return status;
  return Done{};
}

}  // namespace turgor
