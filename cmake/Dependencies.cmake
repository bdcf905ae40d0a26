# Everything comes from Debian 12 (packages.txt, packages-test.txt). ITK is found in apps/morgagni-import alone: the
# import process is the only one that links it.
find_package(Eigen3 3.4 REQUIRED)
find_package(TBB REQUIRED)
find_package(spdlog REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nanoflann REQUIRED)
find_package(meshoptimizer REQUIRED)
find_package(PNG REQUIRED)
find_package(OpenCL REQUIRED)
find_package(ZLIB REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PkgConfig REQUIRED)
pkg_check_modules(EGL REQUIRED IMPORTED_TARGET epoxy egl)
pkg_check_modules(GLIB REQUIRED IMPORTED_TARGET glib-2.0)
pkg_check_modules(GSTREAMER REQUIRED IMPORTED_TARGET
                  gstreamer-1.0 gstreamer-app-1.0 gstreamer-video-1.0 gstreamer-webrtc-1.0 gstreamer-sdp-1.0)
pkg_check_modules(LIBAV REQUIRED IMPORTED_TARGET libavformat libavcodec libavutil)
pkg_check_modules(TURBOJPEG REQUIRED IMPORTED_TARGET libturbojpeg)
pkg_check_modules(ZSTD REQUIRED IMPORTED_TARGET libzstd)
pkg_check_modules(PANGOCAIRO REQUIRED IMPORTED_TARGET pangocairo cairo-pdf)
pkg_check_modules(LIBZIP REQUIRED IMPORTED_TARGET libzip)
pkg_check_modules(SOUP REQUIRED IMPORTED_TARGET libsoup-3.0)
find_library(YUV_LIBRARY yuv REQUIRED)

# Calibration. OpenCV's CMake files come with all of it only.
find_path(OPENCV_INCLUDE_DIR opencv2/aruco/charuco.hpp PATH_SUFFIXES opencv4 REQUIRED)
find_library(OPENCV_ARUCO_LIBRARY opencv_aruco REQUIRED)
find_library(OPENCV_CALIB3D_LIBRARY opencv_calib3d REQUIRED)
find_library(OPENCV_IMGPROC_LIBRARY opencv_imgproc REQUIRED)
find_library(OPENCV_CORE_LIBRARY opencv_core REQUIRED)

# Loaded at run time: only their headers are needed.
find_path(FREENECT_INCLUDE_DIR libfreenect.h REQUIRED)
find_path(OPENNI2_INCLUDE_DIR OniCAPI.h PATH_SUFFIXES openni2 REQUIRED)

if(MORGAGNI_BUILD_TESTS)
  find_package(GTest REQUIRED)
  find_package(assimp REQUIRED)  # It and lib3mf read exported files.
  pkg_check_modules(LIB3MF REQUIRED IMPORTED_TARGET lib3MF)
endif()
if(MORGAGNI_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
