#include "c/world.hpp"

#include "c/sized.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/core/thread_limit.hpp"
#include "turgor/geometry/reorient.hpp"
#include "turgor/io/volume/volume_file.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor::c {

namespace {

constexpr std::uint32_t kMajor = TG_VERSION / 10000, kMinor = TG_VERSION / 100 % 100;
static_assert(TG_VERSION == TURGOR_VERSION_NUMBER, "TG_VERSION in turgor.h differs from project(VERSION)");

tg_world_def default_def() {
  tg_world_def def{};
  def.size = sizeof def;
  return def;
}

std::vector<std::string> overrides_of(const tg_world_def& def) {
  std::vector<std::string> texts;
  expect(def.override_count == 0 || def.overrides, "expected overrides, found null");
  for (std::size_t n = 0; n < def.override_count; n++) {
    expect(def.overrides[n] != nullptr, "expected an override as key=value, found null");
    texts.emplace_back(def.overrides[n]);
  }
  return texts;
}

Vec3d vec_of(const double* v) { return {v[0], v[1], v[2]}; }

CtVolume volume_of(const tg_volume& given) {
  expect(given.body && given.hu, "expected a volume with the name of its body and its samples, found null");
  CtVolume ct;
  for (const std::int32_t n : given.samples)
    expect(n > 0 && n < 65536, "expected a volume's samples along i, j and k");
  ct.grid = {.size = {given.samples[0], given.samples[1], given.samples[2]},
             .spacing = vec_of(given.spacing),
             .origin = vec_of(given.origin),
             .axes = {{vec_of(given.axes), vec_of(given.axes + 3), vec_of(given.axes + 6)}}};
  const Mat3d square = transposed(ct.grid.axes) * ct.grid.axes;
  for (int a = 0; a < 3; a++) {
    expect(ct.grid.spacing[a] > 0, "expected a volume's spacing above 0");
    for (int b = 0; b < 3; b++)
      expect(std::abs(square.column[a][b] - (a == b)) < 1e-3, "expected orthonormal axes of a volume");
  }
  required(io::check_grid(std::string("the volume of ") + given.body, ct.grid));
  ct.samples.assign(given.hu, given.hu + sample_count(ct.grid));
  return right_handed(std::move(ct));
}

void set_volumes(const tg_world_def& def, Scene& scene) {
  expect(def.volume_count == 0 || def.volumes, "expected volumes, found null");
  const char* next = reinterpret_cast<const char*>(def.volumes);
  for (std::size_t n = 0; n < def.volume_count; n++) {
    const tg_volume given = taken(reinterpret_cast<const tg_volume*>(next), tg_volume{});
    next += given.size;
    auto ct = std::make_shared<const CtVolume>(volume_of(given));
    bool found = false;
    for (LatticeScene& body : scene.lattice_bodies)
      if (body.name == given.body) body.ct.given = ct, found = true;
    if (!found)
      throw Refused(std::string(given.body) +
                    ": expected a body with model = \"lattice\" for the volume, found none");
  }
}

Scene scene_of(const tg_world_def& def) {
  expect((def.scene != nullptr) != (def.text != nullptr), "expected either a scene's file or its text");
  const std::vector<std::string> overrides = overrides_of(def);
  Scene scene =
      def.scene
          ? required(read_scene(def.scene, overrides))
          : required(parse_scene(
                def.text, std::filesystem::path(def.folder ? def.folder : ".") / "scene.toml", overrides));
  set_volumes(def, scene);
  return scene;
}

BeginWork begin_of(const tg_world_def& def) {
  if (!def.progress) return {};
  return [report = def.progress, context = def.progress_context](const std::string& label,
                                                                 const std::string&) -> Progress {
    return [=](double fraction) { report(context, label.c_str(), fraction); };
  };
}

FrameReport finite_step(tg_world& world) {
  const FrameReport report = required(step(world.exec, *world.world));
  if (!report.finite) throw Refused("a step was not finite; the state before it was kept");
  return report;
}

/// A saved world has no haptic thread.
void expect_between_frames(const tg_world& world, const char* path) {
  expect(path != nullptr, "expected a file, found null");
  expect_unended(world);
  expect(!world.was_touched && !world.driven,
         "expected a world that is stepped by tg_world_step, found one with haptic ticks");
}

void resize_buffers(tg_world& world) {
  world.commands.resize(world.world->tools.size());
  world.readings.resize(world.world->tools.size());
}

}  // namespace

void expect_unended(const tg_world& world) {
  expect(world.touched || !world.was_touched,
         "expected a new world, or a copy from before tg_touch_begin, found a world whose haptic session has "
         "ended");
}

}  // namespace turgor::c

using namespace turgor;
using namespace turgor::c;

uint32_t tg_version(void) { return TG_VERSION; }

tg_status tg_check_version(uint32_t header) {
  return guarded([header] {
    // with major version 0, minor versions are incompatible
    if (header / 10000 != kMajor || header / 100 % 100 != kMinor || header > TG_VERSION)
      throw Misuse("expected a header of version " + std::to_string(TG_VERSION / 100 * 100) + " to " +
                   std::to_string(TG_VERSION) + ", found " + std::to_string(header));
  });
}

const char* tg_error(void) { return current_error(); }

tg_status tg_default_world_def(tg_world_def* def, size_t size) {
  return guarded([=] { fill_defaults(default_def(), def, size); });
}

tg_status tg_world_create(const tg_world_def* given, tg_world** world) {
  return guarded([=] {
    expect(world != nullptr, "expected a pointer to a world, found null");
    *world = nullptr;
    const tg_world_def def = taken(given, default_def());
    if (const Status sound = check_threads(def.threads); !sound) throw Misuse(sound.error().message);
    auto made = std::make_unique<tg_world>(def.threads);
    made->scene = std::make_shared<const Scene>(scene_of(def));
    made->world = std::make_unique<World>(required(load_world(made->exec, *made->scene, begin_of(def))));
    made->measures = make_measures(*made->world), made->loaded = loaded_world(*made->world);
    resize_buffers(*made);
    *world = made.release();
  });
}

tg_status tg_world_save(tg_world* world, const char* path) {
  return with(world, [path](tg_world& w) {
    expect_between_frames(w, path);
    required(save_world(path, *w.scene, *w.world, w.measures, w.loaded));
  });
}

tg_status tg_world_load(tg_world* world, const char* path) {
  return with(world, [path](tg_world& w) {
    expect_between_frames(w, path);
    const std::uint64_t cuts_before = cuts_hash(*w.world);
    required(read_saved_world(w.exec, path, *w.scene, w.loaded, *w.world, w.measures));
    w.is_shown = false;
    if (cuts_hash(*w.world) != cuts_before)
      w.snapshot = {}, w.replaced_cuts++;  // its caches are those of other cuts
  });
}

tg_status tg_world_copy(tg_world* world, tg_world** copy) {
  return with(world, [copy](tg_world& from) {
    expect(copy != nullptr, "expected a pointer to a copy, found null");
    expect(!from.touched,
           "expected a world without haptic thread, found one between tg_touch_begin and tg_touch_end");
    *copy = nullptr;
    auto made = std::make_unique<tg_world>(1);
    made->exec = from.exec, made->scene = from.scene, made->driven = from.driven,
    made->was_touched = from.was_touched, made->measures = from.measures, made->loaded = from.loaded,
    made->replaced_cuts = from.replaced_cuts;
    made->world = std::make_unique<World>(copy_of(*from.world));
    resize_buffers(*made);
    *copy = made.release();
  });
}

tg_status tg_world_destroy(tg_world* world) {
  return guarded([world] {
    if (world)
      expect(!world->is_busy && !world->is_ticked,
             "expected a world without calls in progress, found one in a call");
    delete world;
  });
}

tg_status tg_world_get_info(tg_world* world, tg_world_info* info) {
  return with(world, [info](tg_world& w) {
    tg_world_info filled{};
    filled.time = time_of(*w.world), filled.frame_dt = w.world->dt, filled.duration = w.scene->duration;
    filled.frame = w.world->frame;
    for_each_body(*w.world, [&](BodyId, const auto&) { filled.bodies++; });
    filled.tools = std::int32_t(w.world->tools.size());
    fill(filled, info);
  });
}

tg_status tg_world_state_hash(tg_world* world, uint64_t* hash) {
  return with(world, [hash](tg_world& w) {
    expect(hash != nullptr, "expected a pointer to a hash, found null");
    expect(!w.touched,
           "expected a world without haptic thread, found one between tg_touch_begin and tg_touch_end");
    *hash = state_hash(*w.world);
  });
}

tg_status tg_world_step(tg_world* world, int32_t frames) {
  return with(world, [frames](tg_world& w) {
    expect(frames >= 0, "expected a number of frames of at least 0");
    expect_unended(w);
    expect(
        !w.driven || w.touched,
        "expected tg_world_tick, which includes frames, or an earlier tg_touch_begin, found tg_world_step");
    w.is_shown = false;
    for (std::int32_t n = 0; n < frames; n++)
      measure_frame(w.exec, *w.world, finite_step(w), false, w.measures);
  });
}
