/* A game engine: a haptic thread moves the tool and reads its force a thousand times a second, while the game loop steps
 * the physics and reads the surfaces to draw. Neither waits for the other.
 *
 *   cc -std=c99 game.c -lturgor_c -lpthread
 */
#define _POSIX_C_SOURCE 200112L
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <turgor.h>

static const char* scene =
    "[world]\n"
    "duration = 10\n"
    "frame_rate = 60\n"
    "[body.liver]\n"
    "model = \"rhombus\"\n"
    "surface = { phantom = \"liver\", detail = 0.5 }\n"
    "[tool.finger]\n"
    "body = \"liver\"\n"
    "shape = { sphere = 0.006 }\n"
    "press = { at_fraction = [0.3, 0.5, 1], depth = 0.006, start = 0, duration = 0.1, hold = 1 }\n";

struct hand {
  tg_world* world;
  tg_command command;
  volatile int ends;
  long ticks;
  double largest; /* [N] */
};

static void sleep_for(long nanoseconds) {
  struct timespec pause;
  pause.tv_sec = 0;
  pause.tv_nsec = nanoseconds;
  nanosleep(&pause, NULL);
}

/* Simulates a haptic device: moves 12 mm down and up again, repeatedly. */
static void* haptic_thread(void* argument) {
  struct hand* hand = argument;
  const double start = hand->command.position[2];
  tg_reading reading;
  while (!hand->ends) {
    const long phase = hand->ticks % 400;
    hand->command.position[2] = start - 0.06e-3 * (double)(phase < 200 ? phase : 400 - phase);
    if (tg_touch_tick(hand->world, &hand->command, sizeof hand->command, &reading, sizeof reading) != TG_OK) {
      fprintf(stderr, "tick: %s\n", tg_error());
      return NULL;
    }
    if (reading.force[2] > hand->largest) hand->largest = reading.force[2];
    hand->ticks++;
    sleep_for(1000000);
  }
  return NULL;
}

static int failed(const char* what) {
  fprintf(stderr, "%s: %s\n", what, tg_error());
  return 1;
}

int main(void) {
  struct hand hand = {0};
  tg_world_def def;
  tg_body_info liver = {0};
  float* points;
  pthread_t thread;
  double lowest = 0;
  int frame, drawn = 0;

  tg_default_world_def(&def, sizeof def);
  def.text = scene;
  if (tg_world_create(&def, &hand.world) != TG_OK) return failed("world");
  if (tg_tool_get_command(hand.world, 0, &hand.command) != TG_OK) return failed("finger");
  liver.size = sizeof liver;
  if (tg_body_get_info(hand.world, 0, &liver) != TG_OK) return failed("liver");
  points = malloc(3 * sizeof *points * (size_t)liver.vertices);
  if (!points) return 1;

  if (tg_touch_begin(hand.world) != TG_OK) return failed("touch");
  if (pthread_create(&thread, NULL, haptic_thread, &hand) != 0) return 1;
  for (frame = 0; frame < 60; frame++) {
    const uint64_t shape = liver.topology_version;
    size_t count = 0, n;
    if (tg_world_step(hand.world, 1) != TG_OK) return failed("frame");
    if (tg_body_get_info(hand.world, 0, &liver) != TG_OK) return failed("liver");
    if (liver.topology_version != shape) break; /* a cut: reallocate buffers here */
    if (tg_body_read(hand.world, 0, TG_DISPLACEMENT, points, 3 * (size_t)liver.vertices, &count) != TG_OK) return failed("points");
    for (n = 2; n < count; n += 3)
      if (points[n] < lowest) lowest = points[n];
    drawn++;
    sleep_for(1000000000L / 60);
  }
  hand.ends = 1;
  pthread_join(thread, NULL);
  tg_touch_end(hand.world);
  printf("%d frames, %ld ticks, at most %.2f N, pressed in by %.1f mm\n", drawn, hand.ticks, hand.largest, -1e3 * lowest);
  free(points);
  tg_world_destroy(hand.world);
  return hand.largest > 0.01 && lowest < -1e-3 ? 0 : 1;
}
