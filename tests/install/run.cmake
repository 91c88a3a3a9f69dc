# Installs a build and uses it from outside the tree:
#   cmake -DBUILD=build/release -DSOURCE=$PWD -DIO=ON [-DSANITIZE=address] -P tests/install/run.cmake
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV} failed (${status}):\n${output}")
  endif()
endfunction()

# Writes the first block of this language in a page to a file, as printed.
function(extract page language file)
  file(READ ${SOURCE}/${page} text)
  string(REPLACE ";" "\\;" text "${text}")
  if(NOT "\n${text}" MATCHES "\n```${language}\n([^`]*)```")
    message(FATAL_ERROR "${page}: expected a block of ${language}, found none")
  endif()
  set(block "${CMAKE_MATCH_1}")
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
consume(sim ${pictures})
consume(all)
configure(io ${pictures} nlohmann_json PkgConfig)
configure(view meshoptimizer nlohmann_json)
configure(pictures)
file(STRINGS ${prefix}/lib/cmake/turgor/turgorTargets.cmake window REGEX "add_library\\(turgor::window" LIMIT_COUNT 1)
if(window)
  configure(window)
endif()
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

# The C component alone is complete.
run(${CMAKE_COMMAND} --install ${BUILD} --component c --prefix ${folder}/only-c)
run(${CMAKE_COMMAND} -S ${folder}/game -B ${folder}/game/only-c ${flags} -DCMAKE_PREFIX_PATH=${folder}/only-c)
run(${CMAKE_COMMAND} --build ${folder}/game/only-c)
