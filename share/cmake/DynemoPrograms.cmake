# Completion of every program of dynemo_add_program(), and the API pages.
get_property(DYNEMO_PROGRAMS GLOBAL PROPERTY DYNEMO_PROGRAMS)

# Completion is loaded by the name of the program.
list(JOIN DYNEMO_PROGRAMS " " DYNEMO_PROGRAM_NAMES)
set(completions ${CMAKE_BINARY_DIR}/share/bash-completion/completions)
foreach(program ${DYNEMO_PROGRAMS})
  configure_file(${PROJECT_SOURCE_DIR}/share/completion/dynemo.bash.in ${completions}/${program} @ONLY)
endforeach()
install(DIRECTORY ${completions}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT programs)

# The pages of the public headers, for developers.
find_program(DOXYGEN doxygen)
if(DOXYGEN)
  file(GLOB DYNEMO_PUBLIC_HEADERS CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/libs/*/include)
  list(JOIN DYNEMO_PUBLIC_HEADERS " " DYNEMO_PUBLIC_HEADERS)
  configure_file(${PROJECT_SOURCE_DIR}/share/doc/Doxyfile.in ${CMAKE_BINARY_DIR}/Doxyfile @ONLY)
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/doc)
  add_custom_target(api-doc COMMAND ${DOXYGEN} ${CMAKE_BINARY_DIR}/Doxyfile COMMENT "API pages in ${CMAKE_BINARY_DIR}/doc/html")
endif()
