# Shared by ./run and ./test: what is missing is installed, then everything is built. Sourced, not run.

readonly BUILD=build/release

say() { printf '\033[1m==> %s\033[0m\n' "$*"; }

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo "$@"; fi
}

# The packages of these lists that are not installed. Node.js may come from elsewhere than Debian.
missing_packages() {
  local package
  sed -e 's/#.*//' -e '/^\s*$/d' "$@" | while read -r package; do
    case $package in
      nodejs) command -v node >/dev/null && continue ;;
      npm) command -v npm >/dev/null && continue ;;
    esac
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || echo "$package"
  done
}

install_packages() {
  local missing
  missing=$(missing_packages "$@")
  [ -n "$missing" ] || return 0
  say "Installing from Debian:" $missing
  # Debian starts Orthanc as a service that listens on all networks: not on somebody's computer.
  if grep -qx orthanc <<<"$missing" && [ ! -e /etc/systemd/system/orthanc.service ]; then
    as_root mkdir -p /etc/systemd/system && as_root ln -s /dev/null /etc/systemd/system/orthanc.service
  fi
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing
}

# Arguments go to CMake.
build_program() {
  say "Building the program"
  cmake --preset release "$@" >"$BUILD.configure.log" 2>&1 || { cat "$BUILD.configure.log"; return 1; }
  cmake --build --preset release
}

build_page() {
  if [ ! -e web/node_modules/.package-lock.json ] || [ web/package-lock.json -nt web/node_modules/.package-lock.json ]; then
    say "Installing the page's packages from npm"
    # Not `npm ci`: some versions of npm leave other platforms' optional packages out of the lock file and
    # then refuse it. Versions still come from the lock file, which stays as it is.
    (cd web && npm install --no-save --no-audit --no-fund)
  fi
  if [ ! -e "$BUILD/web/index.html" ] || [ -n "$(find web -path web/node_modules -prune -o -type f -newer "$BUILD/web/index.html" -print -quit)" ]; then
    say "Building the page"
    (cd web && npm run --silent build -- --outDir "../$BUILD/web" --emptyOutDir)
  fi
}

# What ./run needs. A build that has the tests keeps them.
set_up() {
  install_packages packages.txt
  mkdir -p build
  if [ -e "$BUILD/CMakeCache.txt" ]; then build_program; else build_program -DMORGAGNI_BUILD_{TESTS,BENCHMARKS}=OFF; fi
  build_page
}

# The same with tests and benchmarks.
set_up_tests() {
  install_packages packages.txt packages-test.txt
  mkdir -p build
  build_program -DMORGAGNI_BUILD_{TESTS,BENCHMARKS}=ON
  build_page
}
