#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The wall checker must be able to fail: one fault at a time in a small repository, and it must
# name each. Usage: check_catches.sh CHECKER
set -euo pipefail
checker=$(realpath "$1")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

fresh() {
  rm -rf "${work:?}/r"
  mkdir -p "$work/r/docs" "$work/r/src/watersky/"{low,mid,top}/detail
  cd "$work/r"
  cat > docs/architecture.md << 'EOF'
<!-- layering: -->
| module | what | includes | headers show | sources use |
|---|---|---|---|---|
| `low` | a | | Eigen | |
| `mid` | b | low | | GDAL, PROJ |
| `top` | c | mid | OpenCV | |
<!-- end of layering -->
EOF
  echo 'foreach(module low mid top)' > CMakeLists.txt
  local m
  for m in low mid top; do
    printf '// SPDX-License-Identifier: MIT\n#pragma once\n#include <vector>\n' > "src/watersky/$m/$m.hpp"
    printf '// SPDX-License-Identifier: MIT\n#pragma once\n' > "src/watersky/$m/detail/inner.hpp"
    printf '#include "watersky/%s/%s.hpp"\n#include "watersky/%s/detail/inner.hpp"\n' "$m" "$m" "$m" > "src/watersky/$m/$m.cpp"
  done
  echo 'watersky_module(low SOURCES low.cpp LINKS Eigen3::Eigen)' > src/watersky/low/CMakeLists.txt
  printf 'watersky_module(mid\n  SOURCES mid.cpp\n  LINKS watersky::low\n  PRIVATE_LINKS GDAL::GDAL PROJ::proj)\n' \
    > src/watersky/mid/CMakeLists.txt
  echo 'watersky_module(top SOURCES top.cpp LINKS watersky::mid opencv_core)' > src/watersky/top/CMakeLists.txt
  echo '#include <Eigen/Core>' >> src/watersky/mid/mid.hpp
  echo '#include <gdal_priv.h>' >> src/watersky/mid/mid.cpp
  echo '#include "watersky/low/low.hpp"' >> src/watersky/top/top.hpp
}

cases=0
wrong=0
# catches WHAT EXPECTED: the checker must fail and say EXPECTED.
catches() {
  local said status=0
  said=$("$checker" "$work/r" 2>&1) || status=$?
  cases=$((cases + 1))
  if [[ $status -eq 0 || $said != *"$2"* ]]; then
    printf 'not caught: %s (status %d)\n%s\n' "$1" "$status" "$said"
    wrong=$((wrong + 1))
  fi
  fresh
}
add() { echo "$2" >> "src/watersky/$1"; }

fresh
"$checker" "$work/r" || { echo "the sound repository is refused"; exit 1; }

add low/low.hpp '#include "watersky/mid/mid.hpp"'
catches 'an upward include' 'low may not include mid'
add low/low.cpp '  #  include "watersky/top/top.hpp"'
catches 'an upward include in a source, oddly spaced' 'low may not include top'
add top/top.cpp '#include "watersky/mid/detail/inner.hpp"'
catches 'the detail of another module' 'is private to mid'
add top/top.hpp '#include "watersky/top/detail/inner.hpp"'
catches 'a public header that needs its detail' 'which is not installed'
add low/low.cpp '#include <opencv2/core.hpp>'
catches 'a package outside the row' 'low may not use OpenCV'
add mid/mid.hpp '#include <proj.h>'
catches 'a private package in a header' 'mid keeps PROJ to its sources'
add top/top.cpp '#include <gdal.h>'
catches 'a private package is not inherited' 'top may not use GDAL'
add low/low.cpp '#include <unheard/of.hpp>'
catches 'a package nobody listed' "is nobody's in packages.txt"
add mid/mid.cpp '#include "low.hpp"'
catches 'a bare include' 'in full'
echo 'watersky_module(low SOURCES low.cpp LINKS Eigen3::Eigen watersky::top)' > src/watersky/low/CMakeLists.txt
catches 'an upward link' 'low may not include top'
echo 'watersky_module(mid SOURCES mid.cpp LINKS watersky::low GDAL::GDAL)' > src/watersky/mid/CMakeLists.txt
catches 'a private package linked publicly' 'only as PRIVATE_LINKS'
echo 'watersky_module(top SOURCES top.cpp LINKS opencv_core)' > src/watersky/top/CMakeLists.txt
catches 'an include that is not linked' "top's LINKS do not reach low"
printf 'watersky_module(mid SOURCES mid.cpp PRIVATE_LINKS watersky::low GDAL::GDAL)\n' > src/watersky/mid/CMakeLists.txt
add mid/mid.hpp '#include "watersky/low/low.hpp"'
catches 'a header that shows what is linked privately' "mid's LINKS do not reach low"
sed -i '/pragma/d' src/watersky/mid/mid.hpp
catches 'a header without #pragma once' 'has no #pragma once'
sed -i 1d src/watersky/mid/mid.hpp
catches 'a header without its licence' 'begins without'
echo 'foreach(module mid low top)' > CMakeLists.txt
catches 'modules out of order' "the table's order is"
split() {  # mid's folder holds a second module, which alone may use OpenCV
  # shellcheck disable=SC2016  # the table's own backquotes
  sed -i 's/^| `top`/| `aside` | lies in mid | low | | OpenCV |\n| `top`/' docs/architecture.md
  echo 'watersky_module(aside SOURCES aside.cpp LINKS watersky::low PRIVATE_LINKS opencv_core)' >> src/watersky/mid/CMakeLists.txt
  printf '// SPDX-License-Identifier: MIT\n#pragma once\n' > src/watersky/mid/aside.hpp
  printf '#include "watersky/mid/aside.hpp"\n#include <opencv2/core.hpp>\n' > src/watersky/mid/aside.cpp
}
split
"$checker" "$work/r" > /dev/null || { echo "a folder of two modules is refused"; "$checker" "$work/r"; exit 1; }
add mid/mid.hpp '#include "watersky/mid/aside.hpp"'
catches 'an include of the other module in one folder' 'mid may not include aside'
split
add mid/mid.cpp '#include <opencv2/core.hpp>'
catches "the other module's package" 'mid may not use OpenCV'
split
add top/top.cpp '#include "watersky/mid/aside.hpp"'
catches 'an include of a module split off' 'top may not include aside'
mkdir src/watersky/odd
catches 'a module outside the table' 'a module that is not in'
sed -i 's/| mid | OpenCV/| mid, high | OpenCV/' docs/architecture.md
catches 'a row that names a module above it' 'which is not in a row above it'
mkdir -p apps/x && echo '#include "watersky/top/detail/inner.hpp"' > apps/x/a.cpp
catches 'a program that looks into detail' 'private to its module'

[[ $wrong -eq 0 ]] || exit 1
echo "$cases faults, all caught"
