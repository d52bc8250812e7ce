# One manual page; see DynemoPrograms.cmake for the variables. Programs with commands list all of them in --help-all.
execute_process(COMMAND ${PROGRAM} --help-all RESULT_VARIABLE no_commands OUTPUT_VARIABLE help ERROR_QUIET)
set(option --help-all)
if(no_commands)
  set(option --help)
  execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
endif()
# The first sentence says what the program is.
string(REGEX MATCH "^[^\n]*" summary "${help}")
string(REGEX REPLACE "[:.;] .*$|[:.;]$" "" summary "${summary}")
get_filename_component(folder ${MANUAL} DIRECTORY)
get_filename_component(page ${MANUAL} NAME_WLE)
file(MAKE_DIRECTORY ${folder})
execute_process(
  COMMAND ${HELP2MAN} --no-info --help-option=${option} --name=${summary} --version-string=${VERSION}
    --manual=DYNEMO-SLAM --source=DYNEMO-SLAM\ ${VERSION} --output=${folder}/${page} ${PROGRAM}
  COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${GZIP} -9nf ${folder}/${page} COMMAND_ERROR_IS_FATAL ANY)
