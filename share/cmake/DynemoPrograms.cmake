# Manual pages and completion of every program of dynemo_add_program(), made from what the programs say of themselves.
get_property(DYNEMO_PROGRAMS GLOBAL PROPERTY DYNEMO_PROGRAMS)

find_program(HELP2MAN help2man)
find_program(GZIP gzip)
if(HELP2MAN AND GZIP)
  set(manuals)
  foreach(program ${DYNEMO_PROGRAMS})
    set(manual ${CMAKE_BINARY_DIR}/share/man/man1/${program}.1.gz)
    add_custom_command(OUTPUT ${manual}
      COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:${program}> -DMANUAL=${manual} -DVERSION=${PROJECT_VERSION}
        -DHELP2MAN=${HELP2MAN} -DGZIP=${GZIP} -P ${CMAKE_CURRENT_LIST_DIR}/DynemoManual.cmake
      DEPENDS ${program} ${CMAKE_CURRENT_LIST_DIR}/DynemoManual.cmake
      COMMENT "Manual page of ${program}" VERBATIM)
    list(APPEND manuals ${manual})
  endforeach()
  add_custom_target(manuals ALL DEPENDS ${manuals})
  install(FILES ${manuals} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT programs)
else()
  message(STATUS "help2man or gzip not found: no manual pages")
endif()

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
