# Installs a build and uses it from outside the tree:
#   cmake -DBUILD=build/release -DSOURCE=$PWD -DIO=ON [-DSANITIZE=address] -P tests/install/run.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV} failed (${status}):\n${output}")
  endif()
endfunction()

# Writes the first block of this language in a page after a heading (by default of the page) to a file, as printed, between the texts
# BEFORE and AFTER.
function(extract page language file)
  cmake_parse_arguments(BLOCK "" "HEADING;BEFORE;AFTER" "" ${ARGN})
  file(READ ${SOURCE}/${page} text)
  string(REPLACE ";" "\\;" text "${text}")
  if(BLOCK_HEADING)
    string(FIND "${text}" "\n${BLOCK_HEADING}\n" begin)
    string(SUBSTRING "${text}" ${begin} -1 text)
  endif()
  if(NOT "\n${text}" MATCHES "\n```${language}\n([^`]*)```")
    message(FATAL_ERROR "${page}: expected a block of ${language}, found none")
  endif()
  set(block "${BLOCK_BEFORE}${CMAKE_MATCH_1}${BLOCK_AFTER}")
  string(REPLACE "\\;" ";" block "${block}")
  file(WRITE ${file} "${block}")
endfunction()

set(folder ${BUILD}/install-test)
set(prefix ${folder}/turgor)
file(REMOVE_RECURSE ${folder})
set(flags -G Ninja -DCMAKE_BUILD_TYPE=Release)
if(SANITIZE)
  list(APPEND flags -DCMAKE_CXX_FLAGS=-fsanitize=${SANITIZE} -DCMAKE_C_FLAGS=-fsanitize=${SANITIZE})
endif()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})

# Installed files name no folder of the machine that built them.
file(GLOB_RECURSE installed ${prefix}/*)
foreach(file IN LISTS installed)
  string(REPLACE "." "\\." pattern "${SOURCE}/")
  file(STRINGS ${file} found REGEX "${pattern}" LIMIT_COUNT 1)
  if(found)
    message(FATAL_ERROR "${file}: expected no path of the source tree, found ${found}")
  endif()
endforeach()

# No installed header includes a library that the window links privately, because programs do not have its folder.
file(GLOB_RECURSE installed ${prefix}/include/turgor/*.hpp)
foreach(file IN LISTS installed)
  file(STRINGS ${file} found REGEX "#include <(imgui|GLFW)" LIMIT_COUNT 1)
  if(found)
    message(FATAL_ERROR "${file}: expected no header of the window's libraries, found ${found}")
  endif()
endforeach()

# Configures a consumer of one component. Packages that the component must not ask for are hidden; all others must be found.
function(configure component)
  set(hidden)
  foreach(package IN LISTS ARGN)
    list(APPEND hidden -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
  endforeach()
  run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${folder}/${component} ${flags} -DCMAKE_PREFIX_PATH=${prefix} -DSOURCE=${SOURCE}
      -DCOMPONENT=${component} ${hidden})
endfunction()

# Builds a consumer of one component and runs it.
function(consume component)
  configure(${component} ${ARGN})
  run(${CMAKE_COMMAND} --build ${folder}/${component})
  run(${folder}/${component}/consumer)
endfunction()
set(pictures Freetype meshoptimizer)
set(readers fmt PNG ZLIB pugixml HDF5 GDCM)
consume(engine ${pictures} ${readers} nlohmann_json PkgConfig)

# The project of the README builds as printed.
extract(README.md cmake ${folder}/readme/CMakeLists.txt)
extract(README.md cpp ${folder}/readme/simulator.cpp)
run(${CMAKE_COMMAND} -S ${folder}/readme -B ${folder}/readme/build ${flags} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${folder}/readme/build)
run(${folder}/readme/build/simulator)
if(NOT IO)
  return()
endif()

# The program that the library starts is installed with it; without work it ends with status 2.
execute_process(COMMAND ${prefix}/bin/turgor-read RESULT_VARIABLE status ERROR_QUIET)
if(NOT status EQUAL 2)
  message(FATAL_ERROR "turgor-read ended with ${status}, expected 2")
endif()
run(${prefix}/bin/turgor --version)
consume(haptics ${pictures} PkgConfig)
extract(docs/haptics.md cpp ${folder}/loop/simulator.cpp)
extract(README.md cmake ${folder}/loop/CMakeLists.txt)
file(READ ${folder}/loop/CMakeLists.txt project)
string(REPLACE "engine" "haptics" project "${project}")
file(WRITE ${folder}/loop/CMakeLists.txt "${project}")
run(${CMAKE_COMMAND} -S ${folder}/loop -B ${folder}/loop/build ${flags} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${folder}/loop/build)
run(${folder}/loop/build/simulator)
consume(sim ${pictures})
consume(all)
configure(io ${pictures} nlohmann_json PkgConfig)
configure(view meshoptimizer nlohmann_json)
configure(pictures)
if(EXISTS ${prefix}/lib/cmake/turgor/turgorWindowTargets.cmake)
  configure(window)
endif()

# A project that can do without turgor is configured where a library of turgor is missing, and can print the reason.
file(WRITE ${folder}/optional/CMakeLists.txt [[
cmake_minimum_required(VERSION 3.22)
project(optional LANGUAGES CXX)
find_package(turgor QUIET COMPONENTS ${COMPONENT})
if(turgor_FOUND OR NOT turgor_NOT_FOUND_MESSAGE MATCHES "${REASON}")
  message(FATAL_ERROR "${COMPONENT}: expected the reason '${REASON}', found '${turgor_NOT_FOUND_MESSAGE}' (${turgor_FOUND})")
endif()
]])
foreach(component_and_module sim/tomlplusplus view/epoxy)
  string(REPLACE "/" ";" words ${component_and_module})
  list(GET words 0 component)
  list(GET words 1 module)
  run(${CMAKE_COMMAND} -E env PKG_CONFIG_LIBDIR=${folder} ${CMAKE_COMMAND} -S ${folder}/optional -B ${folder}/without-${module} ${flags}
      -DCMAKE_PREFIX_PATH=${prefix} -DCOMPONENT=${component} "-DREASON=turgor needs ${module}")
endforeach()

# After scripts/demo, which builds no library of the window, the rules install all others, and a program links them.
file(READ ${BUILD}/library/cmake_install.cmake rules)
string(REPLACE "libturgor_window.a" "libturgor_window-that-is-not-built.a" rules "${rules}")
file(WRITE ${folder}/demo.cmake "${rules}")
run(${CMAKE_COMMAND} -DCMAKE_INSTALL_PREFIX=${folder}/demo -P ${folder}/demo.cmake)
if(EXISTS ${folder}/demo/lib/cmake/turgor/turgorWindowTargets.cmake OR NOT EXISTS ${folder}/demo/lib/libturgor_pictures.a)
  message(FATAL_ERROR "${folder}/demo: expected all libraries apart from the window")
endif()
run(${CMAKE_COMMAND} -S ${SOURCE}/tests/install -B ${folder}/after-demo ${flags} -DCMAKE_PREFIX_PATH=${folder}/demo -DSOURCE=${SOURCE}
    -DCOMPONENT=all)
run(${CMAKE_COMMAND} --build ${folder}/after-demo)
consume(c TBB ${pictures} ${readers} nlohmann_json PkgConfig)

# The C project of docs/in-your-simulator.md builds as printed, and its command line makes a program that finds the library.
set(page docs/in-your-simulator.md)
extract(${page} cmake ${folder}/game/CMakeLists.txt)
extract(${page} c ${folder}/game/game.c)
run(${CMAKE_COMMAND} -S ${folder}/game -B ${folder}/game/build ${flags} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${folder}/game/build)
if(NOT SANITIZE)
  file(STRINGS ${SOURCE}/${page} command REGEX "^    cc .*press\\.c" LIMIT_COUNT 1)
  run(${CMAKE_COMMAND} -E copy ${SOURCE}/c/examples/press.c ${folder})
  run(${CMAKE_COMMAND} -E chdir ${folder} ${CMAKE_COMMAND} -E env HOME=${folder} sh -ec "${command}\n./a.out")
endif()

# So does the block on cuts, in a function that has a world.
extract(${page} c ${folder}/game/cut.h HEADING "## Cuts and stitches")
file(WRITE ${folder}/game/game.c [[
#include <stdio.h>
#include <turgor.h>

static void cut_as_printed(tg_world* world) {
#include "cut.h"
}

int main(void) {
  tg_world_def def;
  tg_world* world;
  double length = 0;
  tg_default_world_def(&def, sizeof def);
  def.text = "[world]\nduration = 1\n[body.torso]\nmodel = \"lattice\"\nfixed = [\"bone\", \"ends\"]\nblock = 2\n"
             "ct = { phantom = \"torso\", size = [64, 48, 40], spacing_mm = [6.5, 6.5, 6.5] }\n";
  if (tg_world_create(&def, &world) != TG_OK) return puts(tg_error()), 1;
  cut_as_printed(world);
  if (tg_world_step(world, 20) != TG_OK) return puts(tg_error()), 1;
  if (tg_world_measure(world, "wounds.hand-1.length_mm", &length, 1, NULL) != TG_OK) return puts(tg_error()), 1;
  tg_world_destroy(world);
  return printf("%g mm\n", length), length > 50 ? 0 : 1;
}
]])
run(${CMAKE_COMMAND} --build ${folder}/game/build)
run(${folder}/game/build/game)

# The C component alone is complete.
run(${CMAKE_COMMAND} --install ${BUILD} --component c --prefix ${folder}/only-c)
run(${CMAKE_COMMAND} -S ${folder}/game -B ${folder}/game/only-c ${flags} -DCMAKE_PREFIX_PATH=${folder}/only-c)
run(${CMAKE_COMMAND} --build ${folder}/game/only-c)
