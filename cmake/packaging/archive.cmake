# cmake -D BUILD=build/release -P cmake/packaging/archive.cmake: writes the archive
# BUILD/aula-VERSION-linux-PROCESSOR.tar.xz of the program, the LV2 plugins, the C interface, and,
# if they are built, the CLAP and VST3 plugins, aula~ for Pure Data, the opcodes of Csound, the
# extension of Godot with its demo and the package of Unity, with the libraries that they need. It
# runs in any folder of a Linux with the C library of the system that it is built on, or a later
# one. Needs Debian's package patchelf, and the targets aula and aula_bundle. BUILD may be
# build/arm64, of .ci/arm64.
cmake_minimum_required(VERSION 3.25)
get_filename_component(BUILD "${BUILD}" ABSOLUTE)
get_filename_component(source "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
load_cache("${BUILD}" READ_WITH_PREFIX "" CMAKE_PROJECT_VERSION CMAKE_TOOLCHAIN_FILE CMAKE_OBJDUMP
           pkgcfg_lib_GLFW_glfw)
cmake_host_system_information(RESULT CMAKE_SYSTEM_PROCESSOR QUERY OS_PLATFORM)
if(CMAKE_TOOLCHAIN_FILE)
    include("${CMAKE_TOOLCHAIN_FILE}")
endif()
set(CMAKE_GET_RUNTIME_DEPENDENCIES_COMMAND "${CMAKE_OBJDUMP}")
string(REPLACE aarch64 arm64 processor "${CMAKE_SYSTEM_PROCESSOR}")
set(name "aula-${CMAKE_PROJECT_VERSION}-linux-${processor}")
set(work "${BUILD}/archive")
set(root "${work}/${name}")
find_program(PATCHELF patchelf REQUIRED)
function(run)
    execute_process(COMMAND ${ARGV} OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
endfunction()

# The files of Aula. Of the development files those of the C interface: the static libraries need
# the development files of other libraries.
file(REMOVE_RECURSE "${work}")
foreach(component program c lv2 clap vst3 pd csound godot unity license)
    run("${CMAKE_COMMAND}" --install "${BUILD}" --component ${component} --prefix "${root}" --strip)
endforeach()
run("${CMAKE_COMMAND}" --install "${BUILD}" --component dev --prefix "${work}/dev")
foreach(file include/aula.h lib/libaula.so lib/pkgconfig/aula.pc share/man/man3)
    cmake_path(GET file PARENT_PATH folder)
    file(COPY "${work}/dev/${file}" DESTINATION "${root}/${folder}")
endforeach()
set(program "${root}/bin/aula")
set(library "${root}/lib/libaula.so.0")
set(bundle "${root}/lib/lv2/aula.lv2")
set(plugin "${bundle}/aula.so")
file(GLOB editor "${bundle}/aula_editor.so")
file(GLOB other_plugins "${root}/lib/clap/aula/aula.clap"
     "${root}/lib/vst3/aula.vst3/Contents/*-linux/aula.so"
     "${root}/lib/godot/addons/aula/libaula_godot.so"
     "${root}/lib/unity/aula/Plugins/*/libaudiopluginaula.so")
foreach(binary "${program}" "${library}" "${plugin}")
    if(NOT EXISTS "${binary}")
        message(FATAL_ERROR "${binary} is missing; build the targets aula and aula_bundle")
    endif()
endforeach()

# Libraries of the system, which its other libraries, as drivers of OpenGL, need in their latest
# version. X11 is needed by GLFW, which the program loads where there is a display; it loads JACK,
# ALSA and OpenGL, too.
set(of_the_system "^(ld-linux|lib(c|m|dl|rt|pthread|resolv|gcc_s|stdc\\+\\+|X11)\\.so)")
# Programs that the binaries contain.
set(readers "${BUILD}/audio/aula_sound_reader" "${BUILD}/audio/aula_sofa_reader"
            "${BUILD}/engine/aula_directivity_reader")

# Where those of another processor are.
file(GLOB folders "${CMAKE_SYSROOT}/lib/*-linux-gnu" "${CMAKE_SYSROOT}/usr/lib/*-linux-gnu")

# copy_libraries(TO FROM BINARY...): the libraries of binaries and readers, as hard links of those
# in FROM if it holds them.
function(copy_libraries to from)
    file(GET_RUNTIME_DEPENDENCIES EXECUTABLES ${readers} LIBRARIES ${ARGN} DIRECTORIES ${folders}
         PRE_EXCLUDE_REGEXES "${of_the_system}" RESOLVED_DEPENDENCIES_VAR found)
    list(APPEND found ${window})
    file(MAKE_DIRECTORY "${to}")
    foreach(library IN LISTS found)
        cmake_path(GET library FILENAME file)
        if(EXISTS "${from}/${file}")
            file(CREATE_LINK "${from}/${file}" "${to}/${file}")
        else()
            file(REAL_PATH "${library}" library)
            file(COPY_FILE "${library}" "${to}/${file}")
            run("${PATCHELF}" --set-rpath "$ORIGIN" "${to}/${file}")
        endif()
    endforeach()
    set(libraries "${found}" PARENT_SCOPE)
endfunction()
# The folders of plugins have their own, to work where a user copies them.
copy_libraries("${bundle}/lib" "" "${plugin}" ${editor})
foreach(other IN LISTS other_plugins)
    cmake_path(GET other PARENT_PATH folder)
    copy_libraries("${folder}/lib" "${bundle}/lib" "${other}")
    run("${PATCHELF}" --set-rpath "$ORIGIN/lib" "${other}")
endforeach()
# What Godot copies beside an exported game.
if(EXISTS "${root}/lib/godot")
    set(addon "${root}/lib/godot/addons/aula")
    file(GLOB needed RELATIVE "${addon}" "${addon}/lib/*")
    list(TRANSFORM needed REPLACE "(.+)" "\t\"\\1\": \"lib\"")
    list(JOIN needed ",\n" needed)
    file(APPEND "${addon}/aula.gdextension"
         "\n[dependencies]\n\nlinux.single.${processor} = {\n${needed}\n}\n")
endif()
set(window "")
if(pkgcfg_lib_GLFW_glfw)
    execute_process(COMMAND "${PATCHELF}" --print-soname "${pkgcfg_lib_GLFW_glfw}"
                    OUTPUT_VARIABLE soname OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
    cmake_path(REPLACE_FILENAME pkgcfg_lib_GLFW_glfw "${soname}" OUTPUT_VARIABLE window)
endif()
copy_libraries("${root}/lib/aula" "${bundle}/lib" "${program}" "${library}" ${window})
foreach(binary "${plugin}" ${editor})
    run("${PATCHELF}" --set-rpath "$ORIGIN/lib" "${binary}")
endforeach()
run("${PATCHELF}" --set-rpath "$ORIGIN/aula" "${library}")
run("${PATCHELF}" --set-rpath "$ORIGIN/../lib/aula" "${program}")
foreach(folder "${bundle}" "${root}/lib/clap/aula"
        "${root}/lib/vst3/aula.vst3/Contents/Resources")
    file(GLOB_RECURSE scenes RELATIVE "${folder}" "${folder}/scenes/*")
    foreach(scene IN LISTS scenes)
        file(REMOVE "${folder}/${scene}")
        file(CREATE_LINK "${root}/share/aula/${scene}" "${folder}/${scene}")
    endforeach()
endforeach()

# Licences: those of the packages of the libraries and of what is compiled in.
file(REMOVE_RECURSE "${root}/share/doc/aula-lv2" "${root}/share/doc/libaula0")
set(documents "${root}/share/doc/aula")
if(editor)
    configure_file("${CMAKE_CURRENT_LIST_DIR}/pugl.copyright"
                   "${documents}/libraries/pugl.copyright" COPYONLY)
endif()
foreach(format clap vst3)
    file(REMOVE_RECURSE "${root}/share/doc/aula-${format}")
    if(EXISTS "${root}/lib/${format}")
        configure_file("${CMAKE_CURRENT_LIST_DIR}/${format}.copyright"
                       "${documents}/libraries/${format}.copyright" COPYONLY)
    endif()
endforeach()
set(packages libcli11-dev libeigen3-dev libglm-dev libhdf5-dev libimgui-dev nlohmann-json3-dev portaudio19-dev
             robin-map-dev)
set(files "")
foreach(library IN LISTS libraries)
    file(REAL_PATH "${library}" library)
    string(REPLACE "${CMAKE_SYSROOT}/" "/" library "${library}")
    string(REGEX REPLACE "^/usr" "" moved "${library}")  # where some packages had it
    list(APPEND files "${library}" "${moved}")
endforeach()
set(query dpkg-query "--admindir=${CMAKE_SYSROOT}/var/lib/dpkg")
execute_process(COMMAND ${query} --search ${files} OUTPUT_VARIABLE owners ERROR_QUIET)
foreach(library IN LISTS libraries)
    file(REAL_PATH "${library}" library)
    cmake_path(GET library FILENAME file)
    string(REPLACE "+" "\\+" file "${file}")
    if(NOT owners MATCHES "([^\n:]+):[^\n]*/${file}\n")
        message(FATAL_ERROR "no package has ${library}: its licence is unknown")
    endif()
    list(APPEND packages "${CMAKE_MATCH_1}")
endforeach()
if(EXISTS "${root}/lib/godot")
    configure_file("${CMAKE_CURRENT_LIST_DIR}/godot.copyright"
                   "${documents}/libraries/godot.copyright" COPYONLY)
endif()
if(EXISTS "${root}/lib/pd")
    list(APPEND packages puredata-dev)
endif()
if(EXISTS "${root}/lib/csound")
    list(APPEND packages libcsound64-dev)
endif()
list(REMOVE_DUPLICATES packages)
list(SORT packages)
set(sources "The libraries in lib/aula and what is compiled into the binaries are those of these
packages of Debian, unchanged but for the folder in which the libraries search each other. The
sources of each version are on https://snapshot.debian.org.\n\n")
foreach(package IN LISTS packages)
    configure_file("${CMAKE_SYSROOT}/usr/share/doc/${package}/copyright"
                   "${documents}/libraries/${package}.copyright" COPYONLY)
    execute_process(COMMAND ${query} --show
                            "--showformat=\${Package} \${Version}, source \${source:Package} \${source:Version}\n"
                            "${package}"
                    OUTPUT_VARIABLE line COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX MATCH "^[^\n]*\n" line "${line}")
    string(APPEND sources "${line}")
endforeach()
file(WRITE "${documents}/libraries/SOURCES" "${sources}")
# The licences that the copyright files refer to.
file(GLOB copyrights "${documents}/libraries/*.copyright")
foreach(copyright IN LISTS copyrights)
    file(READ "${copyright}" text)
    string(REGEX MATCHALL "/usr/share/common-licenses/[A-Za-z]+(-[0-9.]*[0-9])?" licences "${text}")
    foreach(licence IN LISTS licences)
        cmake_path(GET licence FILENAME file)
        configure_file("${licence}" "${documents}/libraries/common-licenses/${file}" COPYONLY)
    endforeach()
endforeach()

run(tar --directory "${work}" --sort=name --owner=root:0 --group=root:0 --use-compress-program "xz -T0"
    --create --file "${BUILD}/${name}.tar.xz" "${name}")
file(REMOVE_RECURSE "${work}")
message(STATUS "${BUILD}/${name}.tar.xz")
