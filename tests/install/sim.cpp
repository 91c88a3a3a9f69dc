// The component sim links: reading a scene that does not exist returns an error message.
#include <cstdio>

#include <turgor/sim/scene/scene.hpp>

int main() {
  const auto scene = turgor::read_scene("no-such-scene.toml");
  std::printf("%s\n", scene ? "?" : scene.error().message.c_str());
  return scene ? 1 : 0;
}
