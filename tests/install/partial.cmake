# Installations of a build that is not complete: cmake -DBUILD=build/release -DSOURCE=$PWD -P tests/install/partial.cmake
set(folder ${BUILD}/install-partial)
file(REMOVE_RECURSE ${folder})

# Runs CMake and checks its exit status and one sentence of its output.
function(expect status sentence)
  execute_process(COMMAND ${CMAKE_COMMAND} ${ARGN} RESULT_VARIABLE actual OUTPUT_VARIABLE output ERROR_VARIABLE output)
  string(REGEX REPLACE "[ \n]+" " " output "${output}")
  if(NOT actual EQUAL status OR NOT output MATCHES "${sentence}")
    message(FATAL_ERROR "cmake ${ARGN}: expected status ${status} and '${sentence}', found ${actual} and '${output}'")
  endif()
endfunction()

# Checks the names of all installed files.
function(expect_files prefix)
  file(GLOB_RECURSE files RELATIVE ${folder}/${prefix} ${folder}/${prefix}/*)
  if(NOT files STREQUAL "${ARGN}")
    message(FATAL_ERROR "${prefix}: expected the files '${ARGN}', found '${files}'")
  endif()
endfunction()

set(build ${folder}/build)
expect(0 "" -S ${SOURCE}/tests/install/partial -B ${build} -G Ninja -DSOURCE=${SOURCE})

# nothing is built: nothing is installed
expect(1 "nothing was installed: .*needed is not built; run `cmake --build" --install ${build} --prefix ${folder}/nothing)
expect_files(nothing)

# an optional target is not built: the rest is complete, and asking for it alone is an error
expect(0 "" --build ${build} --target needed)
expect(0 "optional is not built and not installed; `cmake --build .* --target optional` builds it" --install ${build} --prefix ${folder}/most)
expect_files(most bin/needed share/main.c)
expect(1 "nothing was installed: .*optional is not built" --install ${build} --component extra --prefix ${folder}/extra)
expect_files(extra)

# everything is built
expect(0 "" --build ${build})
expect(0 "" --install ${build} --prefix ${folder}/all)
expect_files(all bin/needed bin/optional share/extra/main.c share/main.c)
