/* C interface of Turgor for game engines, simulators and other languages. C99.
 *
 *   - Every function returns a tg_status. tg_error() returns the error message of the calling thread.
 *   - A struct from the caller begins with its size in bytes, sizeof at compile time of the caller. Structs grow only at
 *     their end, so that older programs work with newer libraries.
 *   - Buffers belong to the caller. Returned names are valid as long as their world.
 *   - Units are meters, kilograms, seconds and newtons. Positions are in the patient frame: x to the left, y to the back,
 *     z to the head.
 *   - No call throws or aborts. A world that returned TG_BROKEN can only be destroyed.
 *
 * Threads: different worlds are independent. A world accepts one calling thread at a time, else it returns TG_MISUSE.
 * Exception: between tg_touch_begin and tg_touch_end one haptic thread calls tg_touch_tick, and one other thread makes all
 * other calls. The two never wait for each other.
 */
#ifndef TURGOR_H
#define TURGOR_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TG_VERSION 200u /* major · 10000 + minor · 100 + patch, of this header */

typedef int32_t tg_status;
enum {
  TG_OK = 0,
  TG_ERROR = 1,    /* error in a file, a scene or a step; the message is for the user */
  TG_MISUSE = 2,   /* error of the caller: null, an invalid index, a buffer that is too small, two threads */
  TG_BROKEN = 3,   /* error of the library: please report the message */
  TG_NO_MEMORY = 4
};

/* Version of the library, and whether the library is compatible with a header of that version. */
uint32_t tg_version(void);
tg_status tg_check_version(uint32_t header_version);

/* Error message of this thread's latest call; "" if it succeeded. Valid until the thread's next call. */
const char* tg_error(void);

typedef struct tg_world tg_world;

/* Progress callback of loading, called from any thread: a label, and the finished fraction in [0, 1]. */
typedef void (*tg_progress)(void* context, const char* label, double fraction);

/* A CT in memory, instead of the file of a lattice. */
typedef struct tg_volume {
  size_t size;
  const char* body;    /* name in the scene */
  int32_t samples[3];  /* along i, j, k */
  double spacing[3];   /* [m] */
  double origin[3];    /* position of sample (0, 0, 0) [m] */
  double axes[9];      /* directions of i, then j, then k; orthonormal */
  const int16_t* hu;   /* i fastest [HU]; copied */
} tg_volume;

typedef struct tg_world_def {
  size_t size;
  const char* scene;             /* a TOML file; null if `text` is given */
  const char* text;              /* text of the scene */
  const char* folder;            /* base of relative paths in `text`; null = the current folder */
  const char* const* overrides;  /* key=value */
  size_t override_count;
  int32_t threads;               /* up to 1024; 0 = one per core */
  tg_progress progress;          /* may be null */
  void* progress_context;
  const tg_volume* volumes;      /* volume_count elements */
  size_t volume_count;
} tg_world_def;

/* Fills in the defaults; `size` = sizeof(tg_world_def). */
tg_status tg_default_world_def(tg_world_def* def, size_t size);

tg_status tg_world_create(const tg_world_def* def, tg_world** world);
/* Independent copy, which continues with the same bits as the original. */
tg_status tg_world_copy(tg_world* world, tg_world** copy);
/* Writes the state to a file, with cuts and stitches by the caller. An earlier file is kept on an error. */
tg_status tg_world_save(tg_world* world, const char* path);
/* Continues from such a file, with the bits of the world that was saved. TG_ERROR: a file of another program,
   scene or CT, or a damaged one; the world is unchanged then. Not for worlds with haptic ticks. */
tg_status tg_world_load(tg_world* world, const char* path);
/* Accepts null. Ends haptic ticks. */
tg_status tg_world_destroy(tg_world* world);

typedef struct tg_world_info {
  size_t size;
  double time;      /* simulated [s] */
  double frame_dt;  /* duration of a frame [s] */
  double duration;  /* of the scene [s] */
  int32_t frame;    /* finished frames */
  int32_t bodies, tools;
} tg_world_info;
tg_status tg_world_get_info(tg_world* world, tg_world_info* info);
/* Hash of all bodies and forces. Equal hashes mean equal bits, for any number of threads. */
tg_status tg_world_state_hash(tg_world* world, uint64_t* hash);

/* Simulates `frames` frames. Tools follow their paths of the scene, or the commands of tg_touch_tick. */
tg_status tg_world_step(tg_world* world, int32_t frames);

typedef struct tg_body_info {
  size_t size;
  const char* name;
  const char* model; /* "sfem", "lattice", "rhombus", "cloth" or "rigid" */
  int32_t vertices, triangles;
  uint64_t topology_version; /* changes when a cut, or tg_world_load, changes vertices and triangles */
} tg_body_info;
tg_status tg_body_find(tg_world* world, const char* name, int32_t* body);
tg_status tg_body_get_info(tg_world* world, int32_t body, tg_body_info* info);

/* Report of the world as JSON, the text of report.json without files and times. `count` (may be null) receives the size
 * with the final zero, even if it exceeds the buffer. Wounds are measured in the frames of tg_world_step. */
tg_status tg_world_report(tg_world* world, char* buffer, size_t capacity, size_t* count);
/* Numbers of the report by a dotted path; entries of an array by their name: "attachments.bed.force_N" is the force of an
 * attachment, "body_contacts.floor.force_z_N" that of a contact of two bodies, "bodies.stone.center_z_m" a position of a
 * rigid body, "wounds.midline.gape_max_mm" the gape of a wound. Each call makes the report again. */
tg_status tg_world_measure(tg_world* world, const char* path, double* buffer, size_t capacity, size_t* count);

enum {
  TG_POINTS = 0,       /* positions of the surface vertices, 3 numbers each [m] */
  TG_REST = 1,         /* rest positions, 3 numbers each [m] */
  TG_DISPLACEMENT = 2, /* displacements, 3 numbers each [m] */
  TG_NORMALS = 3,      /* unit outward normals, 3 numbers each */
  TG_PRESSURE = 4,     /* contact pressure, 1 number each; empty if unknown [Pa] */
  TG_STRETCH = 5       /* skin stretch, 1 number each; empty if unknown [1] */
};
/* Copies a quantity into a buffer of `capacity` numbers. `count` (may be null) receives the size, even if it exceeds the
 * buffer. */
tg_status tg_body_read(tg_world* world, int32_t body, int32_t quantity, float* buffer, size_t capacity, size_t* count);
/* Triangles: 3 vertex indices each, counter-clockwise seen from outside. */
tg_status tg_body_triangles(tg_world* world, int32_t body, int32_t* buffer, size_t capacity, size_t* count);

/* Cut along points on or near the present skin of a lattice: a straight line, or a smooth curve through more than two. */
typedef struct tg_cut {
  size_t size;
  int32_t body;
  const char* name;     /* of the wound in the report; null = the first of hand-1, hand-2, ... that is free */
  const double* points; /* x, y, z of point_count points [m] */
  size_t point_count;
  double depth;         /* below the skin [m] */
  double tilt;          /* of the blade; above 0 its edge leans to the right of its direction [degrees] */
  double duration;      /* of the blade's motion; 0 = instantaneous [s] */
} tg_cut;
/* Single stitch through a wound that is cut. */
typedef struct tg_stitch {
  size_t size;
  int32_t body;
  const char* wound;    /* its name; null = the nearest wound that the stitch crosses */
  const double* points; /* x, y, z of point_count points in the CT, in the order of the thread [m] */
  size_t point_count;
  const char* thread;   /* name of its preset; null = "nylon 3-0" */
  double tension;       /* at which it is knotted [N]; 0 = when the lips meet under it */
  double duration;      /* of the pull [s] */
} tg_stitch;
/* Fill in the defaults: 0.01 m deep, upright, 0.2 s; until the lips meet, 0.5 s. `size` = sizeof(tg_cut), sizeof(tg_stitch). */
tg_status tg_default_cut(tg_cut* cut, size_t size);
tg_status tg_default_stitch(tg_stitch* stitch, size_t size);

/* Start a cut, or lay and pull a stitch, in the frame that is computed next. They have the bits of the same cut and stitch
 * in a scene. `name` (may be null) receives the name in the report. What is refused leaves the world unchanged. */
tg_status tg_world_cut(tg_world* world, const tg_cut* cut, const char** name);
tg_status tg_world_stitch(tg_world* world, const tg_stitch* stitch, const char** name);
/* Pulls a stitch by hand further or loosens it: to a tension [N], 0 = until the lips meet; `duration` of the pull [s]. */
tg_status tg_world_tighten(tg_world* world, const char* stitch, double tension, double duration);

typedef struct tg_tool_info {
  size_t size;
  const char* name;
  int32_t body; /* index of the touched body */
} tg_tool_info;
tg_status tg_tool_find(tg_world* world, const char* name, int32_t* tool);
tg_status tg_tool_get_info(tg_world* world, int32_t tool, tg_tool_info* info);

/* Command of a tool for a tick of one millisecond, and the resulting haptic reading. */
typedef struct tg_command {
  double position[3];    /* [m] */
  double orientation[4]; /* quaternion w, x, y, z of any length except 0 */
  int32_t hold;          /* 1: grasps the tissue in contact, jaws close */
  int32_t reserved;      /* 0 */
} tg_command;
typedef struct tg_reading {
  double force[3];  /* on the tool [N] */
  double torque[3]; /* on the tool, about its origin [N·m] */
  double depth;     /* below the surface at rest [m] */
  double age;       /* age of the model data behind the force; 0: computed in this tick [s] */
  int32_t contacts;
  int32_t beyond;   /* 1: the tool reaches beyond the patch; the force may be incomplete */
} tg_reading;

/* Present command of a tool from its path in the scene. */
tg_status tg_tool_get_command(tg_world* world, int32_t tool, tg_command* command);

/* Runs ticks and the frames between them on the calling thread, with the same bits on every machine: `ticks` times a
 * command and a reading for every tool. `command_size` = sizeof(tg_command), `reading_size` = sizeof(tg_reading). After
 * the first call, tg_world_step is refused. */
tg_status tg_world_tick(tg_world* world, const tg_command* commands, size_t command_size, tg_reading* readings,
                        size_t reading_size, size_t ticks);

/* Ticks on a haptic thread while another thread runs frames with tg_world_step. tg_touch_tick does not allocate or wait. */
tg_status tg_touch_begin(tg_world* world);
tg_status tg_touch_tick(tg_world* world, const tg_command* commands, size_t command_size, tg_reading* readings,
                        size_t reading_size);
/* Requires that no tick is in progress. Afterwards the world can be read and copied, but neither steps nor ticks; a copy
 * from before tg_touch_begin does. */
tg_status tg_touch_end(tg_world* world);

#ifdef __cplusplus
}
#endif

#endif
