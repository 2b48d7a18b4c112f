# Every library the project uses, all from Debian 12. The model modules link only Bullet, Eigen, SUNDIALS, HDF5 and yaml-cpp.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
set(HDF5_PREFER_PARALLEL OFF)
find_package(HDF5 REQUIRED COMPONENTS C)
# The same library as a target, which an installed static library can name (FindHDF5 gives paths and needs the C language).
pkg_search_module(grouser_hdf5 REQUIRED IMPORTED_TARGET hdf5-serial hdf5)
find_package(Boost 1.74 REQUIRED)
if(GROUSER_DIAGNOSIS AND GROUSER_BEKKER)
  find_package(Ceres REQUIRED)
  find_package(NLopt REQUIRED)
  find_package(SUNDIALS REQUIRED COMPONENTS cvodes nvecserial)
endif()
if(GROUSER_VEHICLE)
  # CMake's FindBullet finds single precision; vehicles use float64, which only pkg-config knows.
  pkg_check_modules(bullet64 REQUIRED IMPORTED_TARGET bullet-float64)
  find_package(SUNDIALS REQUIRED COMPONENTS cvodes kinsol nvecserial)  # cvodes holds all of cvode; one program must not link both
endif()
