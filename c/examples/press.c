/* Presses a finger into a pad of tissue, tick by tick, and prints its force.
 *
 *   cc -std=c99 press.c -lturgor_c
 */
#include <stdio.h>
#include <string.h>

#include <turgor.h>

static const char* scene =
    "[world]\n"
    "duration = 1\n"
    "[body.pad]\n"
    "model = \"sfem\"\n"
    "block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }\n"
    "fixed = \"bottom\"\n"
    "young = 5e3\n"
    "poisson = 0.4\n"
    "cache = false\n"
    "[tool.finger]\n"
    "body = \"pad\"\n"
    "shape = { sphere = 0.006 }\n"
    "path = [[0, 0.03, 0.03, 0.04]]\n";

static int failed(const char* what) {
  fprintf(stderr, "%s: %s\n", what, tg_error());
  return 1;
}

int main(void) {
  tg_world_def def;
  tg_world* world = NULL;
  tg_command finger;
  tg_reading reading;
  double largest = 0;
  int tick;

  if (tg_check_version(TG_VERSION) != TG_OK) return failed("turgor");
  if (tg_default_world_def(&def, sizeof def) != TG_OK) return failed("definition");
  def.text = scene;
  if (tg_world_create(&def, &world) != TG_OK) return failed("world");
  if (tg_tool_get_command(world, 0, &finger) != TG_OK) return failed("finger");

  for (tick = 0; tick < 300; tick++) {
    if (tick < 100) finger.position[2] -= 0.1e-3; /* 10 mm in a tenth of a second */
    if (tg_world_tick(world, &finger, sizeof finger, &reading, sizeof reading, 1) != TG_OK) return failed("tick");
    if (tick % 50 == 49)
      printf("%3d ms  at %5.1f mm  %6.3f N  %d contacts\n", tick + 1, 1e3 * finger.position[2], reading.force[2], reading.contacts);
    if (reading.force[2] > largest) largest = reading.force[2];
  }
  tg_world_destroy(world);
  return largest > 0.02 ? 0 : 1; /* the pad resists */
}
