# The library lab: scenarios, their runner, recordings. Only the headers of toml++ are used, so that a package without its library is
# sufficient.
find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h)
if(NOT TOMLPLUSPLUS_INCLUDE_DIR)
    message(FATAL_ERROR "toml++ 3 is missing: install libtomlplusplus-dev (Debian, Ubuntu), tomlplusplus-devel (Fedora) or "
        "tomlplusplus (Homebrew), or run tools/setup; or give TOMLPLUSPLUS_INCLUDE_DIR, the folder that holds toml++/toml.h")
endif()
if(NOT SKBUILD) # the Python package writes no files
    find_path(MATIO_INCLUDE_DIR matio.h)
    find_library(MATIO_LIBRARY matio)
endif()
if(NOT SKBUILD AND (NOT MATIO_INCLUDE_DIR OR NOT MATIO_LIBRARY))
    message(FATAL_ERROR "matio 1.5 is missing: install libmatio-dev (Debian, Ubuntu), matio-devel (Fedora) or libmatio "
        "(Homebrew), or run tools/setup; or give MATIO_INCLUDE_DIR and MATIO_LIBRARY")
endif()

set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)

# Makes a source with the ranges and limits of each board file (board_facts.h), and the list of these, that of the build first.
set(board_sources "")
set(board_pointers "")
set(board_externs "")
foreach(board_name board_file IN ZIP_LISTS LAGLESS_BOARD_NAMES LAGLESS_BOARD_FILES)
    string(MAKE_C_IDENTIFIER "${board_name}" board)
    set(board_source ${CMAKE_CURRENT_BINARY_DIR}/lab/board_${board}.c)
    file(CONFIGURE OUTPUT ${board_source} @ONLY CONTENT "\
#undef LAGLESS_BOARD_FILE
#define LAGLESS_BOARD_FILE \"@board_file@\"
#include \"host_sim/lab/board_facts.h\"
const board_facts_t board_facts_@board@ = BOARD_FACTS;
")
    list(APPEND board_sources ${board_source})
    string(APPEND board_externs "extern const board_facts_t board_facts_${board};\n")
    string(APPEND board_pointers "&board_facts_${board}, ")
endforeach()
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/lab/board_list.c @ONLY CONTENT "\
#include \"host_sim/lab/board_facts.h\"
@board_externs@const board_facts_t *const board_facts[] = {@board_pointers@NULL};
")
add_library(lagless_board_facts OBJECT ${board_sources})
desk_room(lagless_board_facts)
target_link_libraries(lagless_board_facts PUBLIC lagless_rig)

# Reads files of keys and values. It does not depend on the board, and its speed is not important.
add_library(lagless_toml STATIC lab/inputs.c lab/toml_reader.cpp)
set_target_properties(lagless_toml PROPERTIES C_STANDARD 11 C_STANDARD_REQUIRED ON CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON)
target_compile_definitions(lagless_toml PRIVATE _GNU_SOURCE)
target_include_directories(lagless_toml PUBLIC ${CMAKE_SOURCE_DIR})
target_include_directories(lagless_toml SYSTEM PRIVATE ${TOMLPLUSPLUS_INCLUDE_DIR})
target_link_libraries(lagless_toml PRIVATE lagless_flags)
# This level of optimisation compiles in two thirds of the time. Without optimisation the code would be three times slower with the
# sanitizers.
set_source_files_properties(lab/toml_reader.cpp PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:RelWithDebInfo,Release>:-O1;-g1>")

# These sources are compiled once, for all boards: with LAGLESS_ANY_BOARD (hal/board.h) they cannot use a number of a board.
add_library(lagless_lab_shared OBJECT
    ${CMAKE_CURRENT_BINARY_DIR}/lab/board_list.c
    lab/boards.c
    lab/campaign.c
    lab/campaign_alarms.c
    lab/campaign_sigma.c
    lab/campaign_around.c
    lab/campaign_judge.c
    lab/campaign_pair.c
    lab/campaign_run.c
    lab/campaign_text.c
    lab/commission.c
    lab/commission_drive.c
    lab/commission_stage.c
    lab/commission_step.c
    lab/commission_user.c
    lab/course.c
    lab/dynamometer.c
    lab/experiment.c
    lab/experiment_curves.c
    lab/experiment_expression.c
    lab/experiment_functions.c
    lab/experiment_grid.c
    lab/experiment_read.c
    lab/experiment_read_claims.c
    lab/experiment_read_measures.c
    lab/experiment_read_sweeps.c
    lab/experiment_run.c
    lab/experiment_value.c
    lab/experiment_write.c
    lab/fmu_model.c
    lab/json.c
    lab/loopback.c
    lab/map.c
    lab/map_judge.c
    lab/map_scenario.c
    lab/matrix.c
    lab/matrix_board.c
    lab/matrix_run.c
    lab/motor.c
    lab/motor_trial.c
    lab/names.c
    lab/paper.c
    lab/paper_drive.c
    lab/paper_manifest.c
    lab/paper_map.c
    lab/paper_rows.c
    lab/paper_theory.c
    lab/pool.c
    lab/recorder.c
    lab/replay_file.c
    lab/recorder_csv.c
    lab/recorder_mdf.c
    lab/recorder_text.c
    lab/recorder_vcd.c
    lab/runner.c
    lab/runner_text.c
    lab/scenario.c
    lab/scenario_read.c
    lab/scenario_write.c
    lab/tally.c
    lab/times.c
    lab/tune_scenario.c
    lab/units.c
    lab/wire.c
    lab/xml.c
    lab/zip.c
)
desk_room(lagless_lab_shared)
target_compile_definitions(lagless_lab_shared PRIVATE _GNU_SOURCE LAGLESS_ANY_BOARD)
target_compile_options(lagless_lab_shared PRIVATE $<$<COMPILE_LANGUAGE:C>:-Wundef>)
set_source_files_properties(lab/fmu_model.c PROPERTIES COMPILE_DEFINITIONS "LAGLESS_VERSION=\"${PROJECT_VERSION}\"")
target_link_libraries(lagless_lab_shared PUBLIC lagless_rig lagless_toml)
set(LAGLESS_LAB_LIBRARIES m Threads::Threads)
if(NOT SKBUILD)
    target_sources(lagless_lab_shared PRIVATE lab/recorder_mat.c)
    target_include_directories(lagless_lab_shared SYSTEM PRIVATE ${MATIO_INCLUDE_DIR})
    list(APPEND LAGLESS_LAB_LIBRARIES ${MATIO_LIBRARY})
endif()

# The rest depends on the board.
function(lagless_add_lab name rig)
    add_library(${name} STATIC $<TARGET_OBJECTS:lagless_lab_shared> $<TARGET_OBJECTS:lagless_board_facts>
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_duty.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_motor.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_notice.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_reasons.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_rows.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/campaign_space.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/matrix_scaled.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/matrix_table.c
        ${PROJECT_SOURCE_DIR}/host_sim/lab/tune.c
    )
    desk_room(${name})
    target_compile_definitions(${name} PRIVATE _GNU_SOURCE)
    target_link_libraries(${name} PUBLIC ${rig} lagless_toml PRIVATE ${LAGLESS_LAB_LIBRARIES})
endfunction()
lagless_add_lab(lagless_lab lagless_rig)
set(LAGLESS_LAB_LIBRARIES "${LAGLESS_LAB_LIBRARIES}" CACHE INTERNAL "Libraries that the lab links to, for tests with other boards")
if(LAGLESS_SANITIZE) # the counters of executed lines allow only one thread
    set_source_files_properties(lab/pool.c PROPERTIES COMPILE_DEFINITIONS POOL_THREADS_MAX=1u)
endif()
# Motors known by name.
set_source_files_properties(lab/motor.c PROPERTIES COMPILE_DEFINITIONS "LAGLESS_MOTORS=\"${CMAKE_SOURCE_DIR}/host_sim/motors\"")
# The figures of the paper that are files.
set_source_files_properties(lab/paper.c PROPERTIES COMPILE_DEFINITIONS "LAGLESS_EXPERIMENTS=\"${CMAKE_SOURCE_DIR}/host_sim/experiments\"")
