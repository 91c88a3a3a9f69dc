#include "app/commands.hpp"

namespace turgor {

void add_info_command(CLI::App&, Global&) {}

}  // namespace turgor
