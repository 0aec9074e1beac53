# Sets the cache variable VARIABLE to a folder outside the repository that tools/get-NAME fills. A value given by the user stays.
# Otherwise it is the folder in the user's cache if that contains FILE, the last file that the tool writes, or else empty.
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
