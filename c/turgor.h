/* Turgor for programs that are not C++: game engines, simulators, other languages. C99.
 *
 *   - Every function returns a tg_status; what went wrong is a sentence in tg_error(), of the calling thread.
 *   - A struct that the caller makes begins with its size in bytes: sizeof as the caller was compiled.
 * Structs grow at the end only, so that programs of before go on with libraries of later.
 *   - Buffers are the caller's. What the library hands out (names) lives as long as its world.
 *   - Metres, kilograms, seconds, newtons; places in the patient frame: x to the left, y to the back, z to
 * the head.
 *   - No exception and no abort of a call comes through. A world that answers TG_BROKEN can only be
 * destroyed.
 *
 * Threads: different worlds are independent. A world is called by one thread at a time (TG_MISUSE else), with
 * one exception: between tg_touch_begin and tg_touch_end one haptic thread calls tg_touch_tick, and one other
 * thread all the rest. The two never wait for each other.
 */
#ifndef TURGOR_H
#define TURGOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TG_VERSION 100u /* major · 10000 + minor · 100 + patch, of this header */

typedef int32_t tg_status;
enum {
  TG_OK = 0,
  TG_ERROR = 1,  /* of the world: a file, a scene, numbers; the sentence is for the user */
  TG_MISUSE = 2, /* of the caller: null, an index that is none, a buffer that is too small, two threads */
  TG_BROKEN = 3, /* of the library: please report the sentence */
  TG_NO_MEMORY = 4
};

/* Of the library; and whether it does what a header of that version says. */
uint32_t tg_version(void);
tg_status tg_check_version(uint32_t header_version);

/* Why the latest call of this thread failed; "" when it did not. Until the thread's next call. */
const char* tg_error(void);

typedef struct tg_world tg_world;

/* Told while a world is made, from any thread: a word, and the finished fraction in [0, 1]. */
typedef void (*tg_progress)(void* context, const char* doing, double fraction);

/* A CT at hand, in place of a lattice's file. */
typedef struct tg_volume {
  size_t size;
  const char* body;   /* its name in the scene */
  int32_t samples[3]; /* along i, j, k */
  double spacing[3];  /* [m] */
  double origin[3];   /* of sample (0, 0, 0) [m] */
  double axes[9];     /* directions of i, then j, then k; unit and square to each other */
  const int16_t* hu;  /* i fastest [HU]; copied */
} tg_volume;

typedef struct tg_world_def {
  size_t size;
  const char* scene;            /* a TOML file; or null and `text` */
  const char* text;             /* the scene itself */
  const char* folder;           /* that files in `text` are relative to; null = the current one */
  const char* const* overrides; /* key=value */
  size_t override_count;
  int32_t threads;      /* 0 = one a core */
  tg_progress progress; /* may be null */
  void* progress_context;
  const tg_volume* volumes; /* as many as volume_count */
  size_t volume_count;
} tg_world_def;

/* Fills in what holds unless it is changed; `size` = sizeof(tg_world_def). */
tg_status tg_default_world_def(tg_world_def* def, size_t size);

tg_status tg_world_create(const tg_world_def* def, tg_world** world);
/* Another world that goes on as this one does, to the same bits. */
tg_status tg_world_copy(tg_world* world, tg_world** copy);
/* Null is allowed. Ends touching. */
tg_status tg_world_destroy(tg_world* world);

typedef struct tg_world_info {
  size_t size;
  double time;     /* simulated [s] */
  double frame_dt; /* of a frame [s] */
  double duration; /* of the scene [s] */
  int32_t frame;   /* finished */
  int32_t bodies, tools;
} tg_world_info;
tg_status tg_world_get_info(tg_world* world, tg_world_info* info);
/* Equal for equal bits in all bodies and forces, however many threads there are. */
tg_status tg_world_state_hash(tg_world* world, uint64_t* hash);

/* So many frames; tools go on their paths of the scene, or where tg_touch_tick has them. */
tg_status tg_world_step(tg_world* world, int32_t frames);

typedef struct tg_body_info {
  size_t size;
  const char* name;
  const char* model; /* "sfem", "lattice", "rhombus" or "cloth" */
  int32_t vertices, triangles;
  uint64_t topology_version; /* another number, other triangles and vertices: a cut was made */
} tg_body_info;
tg_status tg_body_find(tg_world* world, const char* name, int32_t* body);
tg_status tg_body_get_info(tg_world* world, int32_t body, tg_body_info* info);

enum {
  TG_POINTS = 0,       /* where the vertices of the surface are, 3 numbers each [m] */
  TG_REST = 1,         /* likewise, at rest [m] */
  TG_DISPLACEMENT = 2, /* likewise [m] */
  TG_NORMALS = 3,      /* likewise, unit and outward */
  TG_PRESSURE = 4,     /* of the contact, 1 number each; none where it is not known [Pa] */
  TG_STRETCH = 5       /* of the skin, likewise [1] */
};
/* Into a buffer of `capacity` numbers; `count` (may be null) becomes how many there are, also when they do
 * not fit. */
tg_status tg_body_read(tg_world* world, int32_t body, int32_t quantity, float* buffer, size_t capacity,
                       size_t* count);
/* 3 vertices each, counter-clockwise seen from outside. */
tg_status tg_body_triangles(tg_world* world, int32_t body, int32_t* buffer, size_t capacity, size_t* count);

typedef struct tg_tool_info {
  size_t size;
  const char* name;
  int32_t body; /* that it touches */
} tg_tool_info;
tg_status tg_tool_find(tg_world* world, const char* name, int32_t* tool);
tg_status tg_tool_get_info(tg_world* world, int32_t tool, tg_tool_info* info);

/* What a tick of one millisecond asks of a tool, and what is felt. */
typedef struct tg_command {
  double position[3];    /* [m] */
  double orientation[4]; /* w, x, y, z; of any length but 0 */
  int32_t hold;          /* 1: what is touched is held, jaws close */
  int32_t reserved;      /* 0 */
} tg_command;
typedef struct tg_reading {
  double force[3];  /* on the tool [N] */
  double torque[3]; /* on it, about its origin [N·m] */
  double depth;     /* below the surface at rest [m] */
  double age;       /* of what it was computed from; 0: of this very tick [s] */
  int32_t contacts;
  int32_t beyond; /* 1: more is touched than is known there; the force may lack some of it */
} tg_reading;

/* Where the scene has a tool now. */
tg_status tg_tool_get_command(tg_world* world, int32_t tool, tg_command* command);

/* Ticks and frames in turn on the calling thread, the same bits on any machine: `ticks` times a command and a
 * reading for every tool. `command_size` = sizeof(tg_command), `reading_size` = sizeof(tg_reading). From the
 * first on, tg_world_step is over. */
tg_status tg_world_tick(tg_world* world, const tg_command* commands, size_t command_size,
                        tg_reading* readings, size_t reading_size, size_t ticks);

/* Ticks on a haptic thread while another makes frames with tg_world_step. tg_touch_tick neither allocates nor
 * waits. */
tg_status tg_touch_begin(tg_world* world);
tg_status tg_touch_tick(tg_world* world, const tg_command* commands, size_t command_size,
                        tg_reading* readings, size_t reading_size);
/* No tick is on its way. Touching does not begin a second time. */
tg_status tg_touch_end(tg_world* world);

#ifdef __cplusplus
}
#endif

#endif
