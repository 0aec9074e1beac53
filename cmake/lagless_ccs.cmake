# For Code Composer Studio: writes the sources and options of the image, read from the targets of CMake, into ccs.facts.
# tools/projectspec makes lagless.projectspec, makefile.defs and project_check.c of that file, in the same way as those
# in ti/.

# Lists the target and every library of this project that it links to, each once.
function(lagless_ccs_targets target result)
    set(found ${${result}})
    list(APPEND found ${target})
    get_target_property(libraries ${target} LINK_LIBRARIES)
    foreach(library IN LISTS libraries)
        if(TARGET "${library}" AND NOT library IN_LIST found)
            get_target_property(type ${library} TYPE)
            if(NOT type STREQUAL INTERFACE_LIBRARY)
                lagless_ccs_targets(${library} found)
            endif()
        endif()
    endforeach()
    set(${result} ${found} PARENT_SCOPE)
endfunction()

# The file has one fact per line, `name value`. Semicolons separate the items of a list.
string(TOUPPER "${CMAKE_BUILD_TYPE}" ccs_type)
set(ccs_facts "root ${CMAKE_SOURCE_DIR}
tools ${C2000_CGT}
ware $ENV{C2000WARE_ROOT}
processor ${CMAKE_SYSTEM_PROCESSOR}
flags ${CMAKE_C_FLAGS} ${CMAKE_C_FLAGS_${ccs_type}}
link_options $<TARGET_PROPERTY:lagless,LINK_OPTIONS>
libraries ${CMAKE_C_STANDARD_LIBRARIES}
hex_options ${hex_options}
linker_file ${linker_file}
")

set(ccs_targets)
lagless_ccs_targets(lagless ccs_targets)
foreach(target IN LISTS ccs_targets)
    get_target_property(standard ${target} C_STANDARD)
    get_target_property(extensions ${target} C_EXTENSIONS)
    set(dialect STANDARD)
    if(extensions)
        set(dialect EXTENSION)
    endif()
    string(APPEND ccs_facts "target ${target}
definitions $<TARGET_PROPERTY:${target},COMPILE_DEFINITIONS>
includes $<TARGET_PROPERTY:${target},INCLUDE_DIRECTORIES>
options ${CMAKE_C${standard}_${dialect}_COMPILE_OPTION};$<TARGET_PROPERTY:${target},COMPILE_OPTIONS>
")
    get_target_property(sources ${target} SOURCES)
    get_target_property(folder ${target} SOURCE_DIR)
    foreach(source IN LISTS sources)
        get_filename_component(path "${source}" ABSOLUTE BASE_DIR "${folder}")
        get_source_file_property(options "${path}" TARGET_DIRECTORY ${target} COMPILE_OPTIONS)
        get_source_file_property(definitions "${path}" TARGET_DIRECTORY ${target} COMPILE_DEFINITIONS)
        string(APPEND ccs_facts "source ${path}\n")
        if(options)
            string(APPEND ccs_facts "source_options ${options}\n")
        endif()
        if(definitions)
            string(APPEND ccs_facts "source_definitions ${definitions}\n")
        endif()
    endforeach()
endforeach()
file(GENERATE OUTPUT "${CMAKE_BINARY_DIR}/ccs.facts" CONTENT "${ccs_facts}")

add_custom_command(OUTPUT ccs/lagless.projectspec ccs/makefile.defs ccs/project_check.c
    COMMAND "${Python3_EXECUTABLE}" -B "${CMAKE_SOURCE_DIR}/tools/projectspec" --facts ccs.facts --out ccs
    DEPENDS "${CMAKE_BINARY_DIR}/ccs.facts" "${CMAKE_SOURCE_DIR}/tools/projectspec"
    WORKING_DIRECTORY "${CMAKE_BINARY_DIR}" VERBATIM)
add_custom_target(ccs ALL DEPENDS ccs/lagless.projectspec ccs/makefile.defs ccs/project_check.c)
