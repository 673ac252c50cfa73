# Expect that the objects define no global symbol but the functions of their level. A shared inline
# function could be linked from them and would then run on a machine that lacks its instructions.
string(REPLACE "|" ";" objects "${OBJECTS}")
foreach(object IN LISTS objects)
  execute_process(COMMAND ${NM} --demangle --defined-only --extern-only ${object}
    OUTPUT_VARIABLE symbols RESULT_VARIABLE failed)
  string(REGEX REPLACE "\n$" "" symbols "${symbols}")
  string(REPLACE "\n" ";" symbols "${symbols}")
  list(LENGTH symbols count)
  if(failed OR count EQUAL 0)
    message(FATAL_ERROR "no symbols in ${object}")
  endif()
  foreach(symbol IN LISTS symbols)
    if(NOT symbol MATCHES "^[0-9a-f]+ T millscale::(kernels|neighbor)::${LEVEL}::[a-z_]+\\(")
      message(FATAL_ERROR "${object} exports ${symbol}")
    endif()
  endforeach()
endforeach()
