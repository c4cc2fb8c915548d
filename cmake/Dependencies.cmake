# Everything comes from the Debian packages listed in scripts/packages.txt.
find_package(PkgConfig REQUIRED)
find_package(Threads REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenMesh REQUIRED)
find_package(TBB REQUIRED)
find_package(Ceres REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(spdlog REQUIRED)
find_package(fmt REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(glfw3 REQUIRED)
pkg_check_modules(ARAVIS REQUIRED IMPORTED_TARGET aravis-0.8)
find_package(LibXml2 REQUIRED)
pkg_check_modules(CRYPTO REQUIRED IMPORTED_TARGET libcrypto)
pkg_check_modules(FFMPEG REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil libswscale)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET egl glesv2)
pkg_check_modules(XXHASH REQUIRED IMPORTED_TARGET libxxhash)
pkg_check_modules(LIBZIP REQUIRED IMPORTED_TARGET libzip)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
pkg_check_modules(LIBUSB REQUIRED IMPORTED_TARGET libusb-1.0)
pkg_check_modules(CAIRO REQUIRED cairo-pdf cairo-svg cairo-png)
find_package(ZLIB REQUIRED)
pkg_check_modules(NCURSES REQUIRED IMPORTED_TARGET ncursesw)
pkg_check_modules(GRPC REQUIRED IMPORTED_TARGET grpc++ protobuf)
find_program(PROTOC protoc REQUIRED)
find_program(GRPC_CPP_PLUGIN grpc_cpp_plugin REQUIRED)

# Its header alone: it is compiled behind a guard of our own.
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)

# The narrow OpenCV packages ship neither a CMake nor a pkg-config file: those come only with libopencv-dev.
find_path(OPENCV_INCLUDE_DIR opencv2/core.hpp PATH_SUFFIXES opencv4 REQUIRED)
foreach(module core imgproc imgcodecs calib3d aruco video)
  find_library(OPENCV_${module}_LIBRARY opencv_${module} REQUIRED)
  add_library(opencv::${module} UNKNOWN IMPORTED)
  set_target_properties(opencv::${module} PROPERTIES IMPORTED_LOCATION ${OPENCV_${module}_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${OPENCV_INCLUDE_DIR})
endforeach()

# SuiteSparse comes without a pkg-config file.
find_path(CHOLMOD_INCLUDE_DIR suitesparse/cholmod.h REQUIRED)
find_library(CHOLMOD_LIBRARY cholmod REQUIRED)
add_library(rotunda_cholmod INTERFACE)
target_include_directories(rotunda_cholmod SYSTEM INTERFACE ${CHOLMOD_INCLUDE_DIR})
target_link_libraries(rotunda_cholmod INTERFACE ${CHOLMOD_LIBRARY})

# Debian's yaml-cpp 0.7 and OpenMesh export plain names and variables; give them one spelling.
add_library(rotunda_yaml INTERFACE)
target_link_libraries(rotunda_yaml INTERFACE yaml-cpp)
add_library(rotunda_openmesh INTERFACE)
target_include_directories(rotunda_openmesh SYSTEM INTERFACE ${OPENMESH_INCLUDE_DIRS})
target_link_libraries(rotunda_openmesh INTERFACE OpenMeshCore OpenMeshTools)
