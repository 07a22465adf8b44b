# PkgConfig::HDF5: HDF5 with its dimension scales. Debian's shared library needs libcurl, Kerberos and
# LDAP, 40 libraries in all; its static library needs two, if its driver that reads from networks
# (ROS3) is left out. Since HDF5 1.14 a function refers to the driver: here it has none.
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5)
# Debian names the libraries of HDF5 2 hdf5_serial.
find_library(AULA_HDF5_HL NAMES hdf5_hl hdf5_serial_hl HINTS ${HDF5_LIBRARY_DIRS} REQUIRED)
find_library(AULA_HDF5_HL_ARCHIVE NAMES libhdf5_hl.a libhdf5_serial_hl.a
             HINTS ${HDF5_LIBRARY_DIRS})
find_library(AULA_SZIP sz)
find_library(AULA_HDF5_ARCHIVE NAMES libhdf5.a libhdf5_serial.a HINTS ${HDF5_LIBRARY_DIRS})
set(AULA_HDF5_LIBRARIES "${AULA_HDF5_HL}" ${HDF5_LINK_LIBRARIES})
if(AULA_SZIP AND AULA_HDF5_HL_ARCHIVE AND AULA_HDF5_ARCHIVE)
    set(driver "${PROJECT_BINARY_DIR}/hdf5_driver.c")
    file(CONFIGURE OUTPUT "${driver}" @ONLY CONTENT
"#include <stdint.h>
int64_t H5FD_ros3_init(void);  /* of hid_t */
int64_t H5FD_ros3_init(void) { return -1; }  /* H5I_INVALID_HID */
")
    set(libraries "${AULA_HDF5_HL_ARCHIVE}" "${AULA_HDF5_ARCHIVE}" "${AULA_SZIP}" z m
                  ${CMAKE_DL_LIBS})
    try_compile(AULA_HDF5_ARCHIVE_LINKS
        SOURCE_FROM_CONTENT main.c "int H5open(void); int main(void) { return H5open(); }"
        SOURCE_FROM_FILE hdf5_driver.c "${driver}"
        LINK_LIBRARIES ${libraries})
    if(AULA_HDF5_ARCHIVE_LINKS)
        # Before the archive: the linker takes the function from the first that has it.
        add_library(aula_hdf5_driver OBJECT "${driver}")
        set(AULA_HDF5_LIBRARIES $<TARGET_OBJECTS:aula_hdf5_driver> ${libraries})
    endif()
endif()
set_target_properties(PkgConfig::HDF5 PROPERTIES INTERFACE_LINK_LIBRARIES "${AULA_HDF5_LIBRARIES}")
