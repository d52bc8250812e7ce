# Compiler settings and the three functions every CMakeLists.txt of the project uses.
include(GNUInstallDirs)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
# The two packages that cpack makes: what is not said to belong to the programs is for developers.
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME development)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(DYNEMO_CCACHE ccache)
if(DYNEMO_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${DYNEMO_CCACHE})
endif()

add_library(dynemo_options INTERFACE)
target_compile_features(dynemo_options INTERFACE cxx_std_20)
target_compile_options(dynemo_options INTERFACE
  $<BUILD_INTERFACE:-Wall -Wextra -Wconversion -Wno-sign-conversion -Wshadow -Wnon-virtual-dtor>
  # False alarms of GCC 12 on "literal" + std::string (GCC bug 105651).
  $<BUILD_INTERFACE:-Wno-restrict>
  # Contracted multiply-adds would make results depend on the instruction set.
  $<BUILD_INTERFACE:-ffp-contract=off>)
if(DYNEMO_WERROR)
  target_compile_options(dynemo_options INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(DYNEMO_ASSERTIONS)
  foreach(config RELEASE RELWITHDEBINFO)
    string(REPLACE "-DNDEBUG" "" CMAKE_CXX_FLAGS_${config} "${CMAKE_CXX_FLAGS_${config}}")
  endforeach()
endif()
if(DYNEMO_SANITIZE)
  add_compile_options(-fsanitize=${DYNEMO_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${DYNEMO_SANITIZE})
endif()

# Everything that is installed, and no test: for those who build to install. The check runs before anything is copied.
add_custom_target(installable)
foreach(component programs development)
  install(SCRIPT ${CMAKE_BINARY_DIR}/check_${component}.cmake COMPONENT ${component})
endforeach()
# dynemo_installs(COMPONENT TARGET FILE): the file is installed, and the target makes it (DynemoInstallCheck.cmake).
function(dynemo_installs component target file)
  add_dependencies(installable ${target})
  set_property(GLOBAL APPEND PROPERTY DYNEMO_INSTALLED_${component} ${file})
endfunction()

# dynemo_add_library(NAME SOURCES a.cpp ... DEPENDS dynemo::core ... PRIVATE_DEPENDS ...)
# One library of the data flow: target dynemo_NAME, alias and exported name dynemo::NAME.
function(dynemo_add_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(dynemo_${name} STATIC ${ARG_SOURCES})
  add_library(dynemo::${name} ALIAS dynemo_${name})
  set_target_properties(dynemo_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(dynemo_${name} PUBLIC
    $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>
    $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  target_link_libraries(dynemo_${name} PUBLIC dynemo_options ${ARG_DEPENDS} PRIVATE ${ARG_PRIVATE_DEPENDS})
  install(TARGETS dynemo_${name} EXPORT dynemoTargets)
  dynemo_installs(development dynemo_${name} $<TARGET_FILE:dynemo_${name}>)
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
endfunction()

find_program(HELP2MAN help2man)
find_program(GZIP gzip)
if(NOT HELP2MAN OR NOT GZIP)
  message(STATUS "help2man or gzip not found: no manual pages")
endif()

# The manual page of a program, made of what it says of itself.
function(dynemo_add_manual program)
  set(script ${PROJECT_SOURCE_DIR}/share/cmake/DynemoManual.cmake)
  set(manual ${CMAKE_BINARY_DIR}/share/man/man1/${program}.1.gz)
  add_custom_command(OUTPUT ${manual}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DMANUAL=${manual} -DVERSION=${PROJECT_VERSION}
      -DHELP2MAN=${HELP2MAN} -DGZIP=${GZIP} -P ${script}
    DEPENDS ${program} ${script}
    COMMENT "Manual page of ${program}" VERBATIM)
  add_custom_target(manual_${program} ALL DEPENDS ${manual})
  install(FILES ${manual} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT programs)
  dynemo_installs(programs manual_${program} ${manual})
endfunction()

# dynemo_add_program(NAME SOURCES ... DEPENDS ...): an installed command, with a manual page, and completion
# (DynemoPrograms.cmake).
function(dynemo_add_program name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE ${ARG_DEPENDS})
  install(TARGETS ${name} COMPONENT programs)
  dynemo_installs(programs ${name} $<TARGET_FILE:${name}>)
  set_property(GLOBAL APPEND PROPERTY DYNEMO_PROGRAMS ${name})
  if(HELP2MAN AND GZIP)
    dynemo_add_manual(${name})
  endif()
endfunction()

# dynemo_add_test(NAME SOURCES ... DEPENDS ... [TIMEOUT s]): a GoogleTest program, one CTest test.
function(dynemo_add_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "SOURCES;DEPENDS" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(test_${name} ${ARG_SOURCES})
  target_link_libraries(test_${name} PRIVATE ${ARG_DEPENDS} dynemo_test_support GTest::gtest_main)
  add_test(NAME ${name} COMMAND test_${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${ARG_TIMEOUT})
endfunction()

# dynemo_add_benchmark(NAME SOURCES ... DEPENDS ...): a Google Benchmark program; one short pass of it is a
# test, so that it cannot rot.
function(dynemo_add_benchmark name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(bench_${name} ${ARG_SOURCES})
  target_link_libraries(bench_${name} PRIVATE ${ARG_DEPENDS} dynemo_test_support benchmark::benchmark_main)
  if(DYNEMO_BUILD_TESTS)
    add_test(NAME bench_${name} COMMAND bench_${name} --benchmark_min_time=0.001)
    set_tests_properties(bench_${name} PROPERTIES TIMEOUT 300 LABELS benchmark)
  endif()
endfunction()
