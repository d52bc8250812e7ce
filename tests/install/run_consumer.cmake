# See CMakeLists.txt for the variables. Fails at the first command that fails.
function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ECHO STDOUT COMMAND_ERROR_IS_FATAL ANY)
endfunction()

set(prefix ${SCRATCH_DIR}/prefix)
set(build ${SCRATCH_DIR}/build)
file(REMOVE_RECURSE ${SCRATCH_DIR})
run(${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${prefix})

# An installed program finds the installed setups.
execute_process(COMMAND ${prefix}/bin/dynemo-slam --setup full --dump-config OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)

set(sanitizer_flags)
if(SANITIZE)
  set(sanitizer_flags -fsanitize=${SANITIZE})
endif()
run(${CMAKE_COMMAND} -S ${CONSUMER_DIR} -B ${build} -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_CXX_FLAGS=${sanitizer_flags} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${build})

execute_process(COMMAND ${build}/consumer OUTPUT_VARIABLE output OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
if(NOT output STREQUAL EXPECTED_OUTPUT)
  message(FATAL_ERROR "the consumer printed '${output}', not '${EXPECTED_OUTPUT}'")
endif()

# The example in share/examples, on a run of the installed program.
set(example ${SCRATCH_DIR}/example)
run(${CMAKE_COMMAND} -S ${EXAMPLE_DIR} -B ${example} -G ${GENERATOR}
  -DCMAKE_CXX_COMPILER=${CXX_COMPILER} -DCMAKE_CXX_FLAGS=${sanitizer_flags} -DCMAKE_PREFIX_PATH=${prefix})
run(${CMAKE_COMMAND} --build ${example})
run(${prefix}/bin/dynemo-slam -q --entities ${SAMPLE}_entities.yaml --set outputs=[session]
  --output ${SCRATCH_DIR}/run ${SAMPLE}.rawlog)
execute_process(COMMAND ${example}/query_example ${SCRATCH_DIR}/run OUTPUT_VARIABLE output COMMAND_ERROR_IS_FATAL ANY)
if(NOT output MATCHES "box 2 is at " OR NOT output MATCHES "box 1 was moved by ")
  message(FATAL_ERROR "the example printed '${output}'")
endif()
