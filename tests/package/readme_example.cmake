# The README's example ends well and prints what the README says. Arguments: README, PROGRAM.
execute_process(COMMAND ${PROGRAM} RESULT_VARIABLE result OUTPUT_VARIABLE output)
string(STRIP "${output}" output)
file(READ ${README} page)
string(FIND "${page}" "It prints `${output}`" found)
if(NOT result EQUAL 0 OR output STREQUAL "" OR found LESS 0)
    message(FATAL_ERROR "${PROGRAM} ends with ${result} and prints '${output}', which ${README} does not say")
endif()
