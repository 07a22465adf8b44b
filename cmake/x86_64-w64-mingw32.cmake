# Cross-compiles for Windows by MinGW, with the libraries in the folder that .ci/windows makes; wine
# runs the tests.
set(CMAKE_SYSTEM_NAME Windows)
set(CMAKE_SYSTEM_PROCESSOR x86_64)
set(CMAKE_C_COMPILER x86_64-w64-mingw32-gcc-posix)
set(CMAKE_CXX_COMPILER x86_64-w64-mingw32-g++-posix)
set(CMAKE_RC_COMPILER x86_64-w64-mingw32-windres)
set(CMAKE_CROSSCOMPILING_EMULATOR /usr/lib/wine/wine64)
set(AULA_WINDOWS_LIBRARIES /var/cache/aula-ci/windows CACHE PATH "The folder of the libraries")
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES AULA_WINDOWS_LIBRARIES)
set(CMAKE_FIND_ROOT_PATH /usr/x86_64-w64-mingw32 "${AULA_WINDOWS_LIBRARIES}")
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
foreach(kind LIBRARY INCLUDE PACKAGE)
    set(CMAKE_FIND_ROOT_PATH_MODE_${kind} ONLY)
endforeach()
set(ENV{PKG_CONFIG_LIBDIR} "${AULA_WINDOWS_LIBRARIES}/lib/pkgconfig")
# GCC aligns the stack of Windows to 16 bytes, and takes it for aligned to 32 and 64 (GCC bug
# 54412): the assembler makes moves of vectors that allow it, which are as fast.
add_compile_options("$<$<COMPILE_LANGUAGE:C,CXX>:-Wa,-muse-unaligned-vector-move>")
# The binaries need no library of MinGW beside them.
foreach(kind EXE SHARED MODULE)
    set(CMAKE_${kind}_LINKER_FLAGS_INIT -static)
endforeach()
