# One manual page; see DynemoBuild.cmake for the variables. The help of each command of a program follows as it stands.
execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
# The first sentence says what the program is.
string(REGEX MATCH "^[^\n]*" summary "${help}")
string(REGEX REPLACE "[:.;] .*$|[:.;]$" "" summary "${summary}")
get_filename_component(folder ${MANUAL} DIRECTORY)
get_filename_component(page ${MANUAL} NAME_WLE)
file(MAKE_DIRECTORY ${folder})

set(commands "[commands]\n")
string(REGEX MATCH "\nSubcommands:\n.*" list "${help}")
string(REGEX MATCHALL "\n  [a-z][a-z0-9-]* " names "${list}")
foreach(name ${names})
  string(STRIP "${name}" name)
  execute_process(COMMAND ${PROGRAM} ${name} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\\" "\\\\" help "${help}")
  string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" help "${help}")
  string(APPEND commands ".SS ${name}\n.nf\n${help}.fi\n")
endforeach()
set(include)
if(names)
  file(WRITE ${folder}/${page}.commands "${commands}")
  set(include --include=${folder}/${page}.commands)
endif()

execute_process(
  COMMAND ${HELP2MAN} --no-info --name=${summary} --version-string=${VERSION} ${include}
    --manual=DYNEMO-SLAM --source=DYNEMO-SLAM\ ${VERSION} --output=${folder}/${page} ${PROGRAM}
  COMMAND_ERROR_IS_FATAL ANY)
file(REMOVE ${folder}/${page}.commands)
execute_process(COMMAND ${GZIP} -9nf ${folder}/${page} COMMAND_ERROR_IS_FATAL ANY)
