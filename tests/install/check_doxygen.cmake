# The API pages are made without a warning.
execute_process(COMMAND ${DOXYGEN} ${BUILD_DIR}/Doxyfile OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
file(READ ${BUILD_DIR}/doc/warnings.txt warnings)
if(NOT warnings STREQUAL "")
  message(FATAL_ERROR "doxygen warns:\n${warnings}")
endif()
if(NOT EXISTS ${BUILD_DIR}/doc/html/index.html)
  message(FATAL_ERROR "doxygen made no pages")
endif()
