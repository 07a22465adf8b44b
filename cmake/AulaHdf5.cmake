# PkgConfig::HDF5: HDF5 with its dimension scales. Debian's shared library needs libcurl, Kerberos and
# LDAP, 40 libraries in all; its static library needs two, if what reads from networks is left out.
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5)
# Debian names the libraries of HDF5 2 hdf5_serial.
find_library(AULA_HDF5_HL NAMES hdf5_hl hdf5_serial_hl HINTS ${HDF5_LIBRARY_DIRS} REQUIRED)
find_library(AULA_HDF5_HL_ARCHIVE NAMES libhdf5_hl.a libhdf5_serial_hl.a
             HINTS ${HDF5_LIBRARY_DIRS})
find_library(AULA_SZIP sz)
find_library(AULA_HDF5_ARCHIVE NAMES libhdf5.a libhdf5_serial.a HINTS ${HDF5_LIBRARY_DIRS})
set(AULA_HDF5_LIBRARIES "${AULA_HDF5_HL}" ${HDF5_LINK_LIBRARIES})
if(AULA_SZIP AND AULA_HDF5_HL_ARCHIVE AND AULA_HDF5_ARCHIVE)
    include(CheckCSourceCompiles)
    set(CMAKE_REQUIRED_LIBRARIES "${AULA_HDF5_HL_ARCHIVE}" "${AULA_HDF5_ARCHIVE}"
                                 "${AULA_SZIP}" z m ${CMAKE_DL_LIBS})
    check_c_source_compiles("int H5open(void); int main(void) { return H5open(); }"
                            AULA_HDF5_ARCHIVE_LINKS)
    if(AULA_HDF5_ARCHIVE_LINKS)
        set(AULA_HDF5_LIBRARIES ${CMAKE_REQUIRED_LIBRARIES})
    endif()
    unset(CMAKE_REQUIRED_LIBRARIES)
endif()
set_target_properties(PkgConfig::HDF5 PROPERTIES INTERFACE_LINK_LIBRARIES "${AULA_HDF5_LIBRARIES}")
