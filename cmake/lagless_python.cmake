# The interpreter itself in place of what a version manager puts on the path in front of it: a script that takes longer to start than many
# of our Python programs run, and a check starts it some hundred times. Too old a one is left to find_package, which searches further.
if(NOT Python3_EXECUTABLE)
    execute_process(COMMAND python3 -c "import sys; print(sys.executable if sys.version_info >= (3, 9) else '')"
        OUTPUT_VARIABLE interpreter OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
    if(interpreter AND EXISTS "${interpreter}")
        set(Python3_EXECUTABLE "${interpreter}" CACHE FILEPATH "The Python that tests, pictures and tools run with")
    endif()
endif()
find_package(Python3 3.9 COMPONENTS Interpreter QUIET)
