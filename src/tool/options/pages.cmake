# Man pages and a completion for bash, of what --help prints: cmake -D PROGRAM=FILE -D FOLDER=FOLDER -P pages.cmake
# The folder gets the layout of share/.
cmake_minimum_required(VERSION 3.22)
cmake_path(GET PROGRAM FILENAME name)
execute_process(COMMAND ${PROGRAM} --version OUTPUT_VARIABLE version COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "[0-9.]+" version "${version}")

# Text for roff, with every "-" as one that can be copied into a shell.
function(roff result text)
    string(REPLACE "\\" "\\e" text "${text}")
    foreach(pair IN ITEMS "-\\-" "'\\(aq" "`\\(ga" "^\\(ha" "~\\(ti" "\"\\(dq")
        string(SUBSTRING "${pair}" 0 1 character)
        string(SUBSTRING "${pair}" 1 -1 becomes)
        string(REPLACE "${character}" "${becomes}" text "${text}")
    endforeach()
    set(${result} "${text}" PARENT_SCOPE)
endfunction()

# The page of a command, or of the program if that is "": what it does in a line, the help with headings and options, other pages.
function(write_page command what also)
    execute_process(COMMAND ${PROGRAM} ${command} --help OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
    string(REPEAT " " 25 column)
    string(REPLACE "\n${column}" "\t" text "${text}") # an option takes one line
    string(JOIN "-" page ${name} ${command})
    set(file "${page}.1")
    string(JOIN " " called ${name} ${command})
    string(TOUPPER "${page}" title)
    foreach(part IN ITEMS page called what text also)
        roff(${part} "${${part}}")
    endforeach()
    string(REGEX REPLACE "\n([^ \n])" "\n\\\\&\\1" text "${text}")
    string(REGEX REPLACE "^Usage: ([^\n]*)\n+" ".SH SYNOPSIS\n\\1\n.SH DESCRIPTION\n" text "${text}")
    string(REPLACE "SYNOPSIS\n${called}" "SYNOPSIS\n\\fB${called}\\fR" text "${text}")
    foreach(heading IN ITEMS Commands Options Examples)
        string(TOUPPER "${heading}" upper)
        string(REPLACE "\n\n\\&${heading}:\n" "\n.SH ${upper}\n.nf\n" text "${text}")
    endforeach()
    string(REGEX REPLACE "\n  +([\\]-., |)([\\]-[\\]-[^ \t\n]+)( [^ \t\n]+|)(  +|\t)([^\n]*)"
        "\n.TP\n\\\\fB\\1\\2\\\\fR\\\\fI\\3\\\\fR\n\\\\&\\5" text "${text}")
    string(REPLACE ".nf\n.TP\n" ".TP\n" text "${text}")
    string(REPLACE "\t" " " text "${text}")
    file(WRITE "${FOLDER}/man/man1/${file}" ".TH \"${title}\" 1 \"\" \"cellwalk ${version}\" \"Cellwalk\"\n.nh\n.ad l\n.ss 12 0\n"
        ".SH NAME\n${page} \\- ${what}\n${text}.fi\n.SH ENVIRONMENT\n"
        ".TP\n\\fBCELLWALK_ISA\\fR\nthe highest instruction set to use: scalar, sse4.2, avx2, avx512 or neon\n"
        ".TP\n\\fBCELLWALK_MODULES\\fR\nthe folder of the module that reads files by GDAL, if it is not where it was installed\n"
        ".SH EXIT STATUS\n0 if all went well, 2 if the command line is wrong, 1 after any other failure.\n.SH SEE ALSO\n${also}\n")
endfunction()

execute_process(COMMAND ${PROGRAM} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "^[^\n]*\n([^\n]*[^.\n])\\.?\n" line "${help}")
set(what "${CMAKE_MATCH_1}")
string(REGEX MATCH "\nCommands:(\n  [^\n]*)+" rows "${help}")
string(REPLACE ";" "\\;" rows "${rows}")
string(REGEX MATCHALL "\n  [^\n]+" rows "${rows}")
foreach(row IN LISTS rows)
    string(REGEX MATCH "  ([a-z]+) +(.*)" row "${row}")
    list(APPEND commands ${CMAKE_MATCH_1})
    list(APPEND pages "${name}-${CMAKE_MATCH_1}(1)")
    write_page(${CMAKE_MATCH_1} "${CMAKE_MATCH_2}" "${name}(1)")
endforeach()
list(JOIN pages ", " pages)
write_page("" "${what}" "${pages}")

list(JOIN commands " " commands)
string(MAKE_C_IDENTIFIER "_${name}" function)
file(READ ${CMAKE_CURRENT_LIST_DIR}/completion.bash completion)
file(CONFIGURE OUTPUT ${FOLDER}/bash-completion/completions/${name} CONTENT "${completion}" @ONLY)
