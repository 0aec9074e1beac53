# Ends the configuration with a message if a program that a preset needs is missing, and names the package that contains it.
function(lagless_need preset program package)
    find_program(found ${program} NO_CACHE)
    if(NOT found)
        message(FATAL_ERROR "preset ${preset}: ${program} is missing: install ${package} (Debian, Ubuntu), or run tools/setup")
    endif()
endfunction()

# The same for a file of the compiler's library.
function(lagless_need_library preset compiler file package)
    execute_process(COMMAND ${compiler} -print-file-name=${file} OUTPUT_VARIABLE found OUTPUT_STRIP_TRAILING_WHITESPACE)
    if(NOT IS_ABSOLUTE "${found}")
        message(FATAL_ERROR "preset ${preset}: ${compiler}'s ${file} is missing: install ${package} (Debian, Ubuntu), or run tools/setup")
    endif()
endfunction()
