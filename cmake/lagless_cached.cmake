# A folder that tools/get-NAME fills outside the repository, as the cache variable VARIABLE: as it is given, else the one below the
# user's cache if it has FILE, the last file that the tool puts there; else empty.
function(lagless_cached VARIABLE NAME FILE TEXT)
    set(cache "$ENV{XDG_CACHE_HOME}")
    if(NOT cache)
        set(cache "$ENV{HOME}/.cache")
    endif()
    set(${VARIABLE} "" CACHE PATH "${TEXT}")
    if(NOT ${VARIABLE} AND EXISTS "${cache}/lagless/${NAME}/${FILE}")
        set(${VARIABLE} "${cache}/lagless/${NAME}" CACHE PATH "${TEXT}" FORCE)
    endif()
endfunction()
