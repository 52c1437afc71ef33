# The public header is C++14, 17 and 20 as well as C17, without a warning. Arguments: HEADERS, SOURCE, WORK, COMPILERS.
file(MAKE_DIRECTORY ${WORK})
string(REPLACE "," ";" compilers "${COMPILERS}")
foreach(compiler IN LISTS compilers)
    foreach(standard IN ITEMS 14 17 20)
        execute_process(COMMAND ${compiler} -std=c++${standard} -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Wold-style-cast
            -Werror -I${HEADERS} -c ${SOURCE} -o ${WORK}/consumer.o RESULT_VARIABLE result ERROR_VARIABLE errors)
        if(NOT result EQUAL 0)
            message(FATAL_ERROR "${compiler}, C++${standard}:\n${errors}")
        endif()
    endforeach()
endforeach()
message(STATUS "Compiled by ${COMPILERS}")
