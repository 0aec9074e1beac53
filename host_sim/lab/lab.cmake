# The lab: scenarios, their runner, recordings. toml++ is used as headers alone, so that its package may come with or without
# a library.
find_path(TOMLPLUSPLUS_INCLUDE_DIR toml++/toml.h)
if(NOT TOMLPLUSPLUS_INCLUDE_DIR)
    message(FATAL_ERROR "toml++ 3 is missing: install libtomlplusplus-dev (Debian, Ubuntu), tomlplusplus-devel (Fedora) or "
        "tomlplusplus (Homebrew), or run tools/setup; or give TOMLPLUSPLUS_INCLUDE_DIR, the folder that holds toml++/toml.h")
endif()
find_path(MATIO_INCLUDE_DIR matio.h)
find_library(MATIO_LIBRARY matio)
if(NOT MATIO_INCLUDE_DIR OR NOT MATIO_LIBRARY)
    message(FATAL_ERROR "matio 1.5 is missing: install libmatio-dev (Debian, Ubuntu), matio-devel (Fedora) or libmatio "
        "(Homebrew), or run tools/setup; or give MATIO_INCLUDE_DIR and MATIO_LIBRARY")
endif()

set(THREADS_PREFER_PTHREAD_FLAG ON)
find_package(Threads REQUIRED)

add_library(lagless_lab STATIC
    lab/json.c
    lab/map.c
    lab/map_judge.c
    lab/map_scenario.c
    lab/names.c
    lab/paper.c
    lab/paper_beyond.c
    lab/paper_claims.c
    lab/paper_drive.c
    lab/paper_manifest.c
    lab/paper_measure.c
    lab/paper_rows.c
    lab/paper_runs.c
    lab/paper_theory.c
    lab/paper_write.c
    lab/pool.c
    lab/recorder.c
    lab/recorder_csv.c
    lab/recorder_mat.c
    lab/recorder_text.c
    lab/recorder_vcd.c
    lab/runner.c
    lab/scenario.c
    lab/scenario_read.c
    lab/times.c
    lab/toml_reader.cpp
    lab/units.c
)
desk_room(lagless_lab)
set_target_properties(lagless_lab PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON)
target_compile_definitions(lagless_lab PRIVATE _GNU_SOURCE)
target_include_directories(lagless_lab SYSTEM PRIVATE ${TOMLPLUSPLUS_INCLUDE_DIR} ${MATIO_INCLUDE_DIR})
target_link_libraries(lagless_lab PUBLIC lagless_rig m PRIVATE ${MATIO_LIBRARY} Threads::Threads)
