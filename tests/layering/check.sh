#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Checks the walls between modules against the table in docs/architecture.md.
#
#   tests/layering/check.sh [REPOSITORY]
#
# Per module: its #includes of other modules and of packages, its target links, that what it
# includes is linked, that detail/ stays private and public headers do without it. Every header
# has its licence line and #pragma once. The root CMakeLists.txt names the modules in the
# table's order. One line a fault; status 1 if there is any.
set -euo pipefail
export LC_ALL=C.UTF-8
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
cd "${1:-$here/../..}"
table=docs/architecture.md
packages=$here/packages.txt

faults=0
fault() {
  printf '%s\n' "$*"
  faults=$((faults + 1))
}

# --- The table ---------------------------------------------------------------------------
order=()
declare -A includes shows uses
while IFS='|' read -r _ module _ row_includes row_shows row_uses _; do
  module=$(tr -d ' `' <<< "$module")
  [[ -n $module && $module != module && $module != -* ]] || continue
  order+=("$module")
  includes[$module]=$(tr ',' ' ' <<< "$row_includes")
  shows[$module]=$(tr ',' ' ' <<< "$row_shows")
  uses[$module]=$(tr ',' ' ' <<< "$row_uses")
done < <(sed -n '/<!-- layering:/,/<!-- end of layering/p' "$table" | grep '^|')
[[ ${#order[@]} -gt 0 ]] || { echo "$table has no table of modules"; exit 1; }

# below[m]: all modules m may include, itself included; open[m]: packages its headers may show.
declare -A below open
for module in "${order[@]}"; do
  below[$module]=" $module "
  open[$module]=" ${shows[$module]} "
  for other in ${includes[$module]}; do
    if [[ -z ${below[$other]:-} ]]; then
      fault "$table: $module includes $other, which is not in a row above it"
      continue
    fi
    below[$module]+="${below[$other]}"
    open[$module]+="${open[$other]}"
  done
done

# --- Packages ----------------------------------------------------------------------------
declare -A prefixes targets
names=()
while read -r name starts links _; do
  [[ -n $name && $name != '#'* ]] || continue
  names+=("$name")
  prefixes[$name]=${starts//,/ }
  targets[$name]=${links//,/ }
done < "$packages"
for module in "${order[@]}"; do
  for name in ${shows[$module]} ${uses[$module]}; do
    [[ -n ${prefixes[$name]:-} ]] || fault "$table: $module names $name, which is not in packages.txt"
  done
done

# Sets `package` to whose include or target it is; empty when nobody's.
package_of_include() {
  local name start
  package=
  for name in "${names[@]}"; do
    for start in ${prefixes[$name]}; do
      if [[ $1 == "$start"* ]]; then package=$name; return; fi
    done
  done
}
package_of_target() {
  local name pattern
  package=
  set -f
  for name in "${names[@]}"; do
    for pattern in ${targets[$name]}; do
      # shellcheck disable=SC2053  # a pattern on purpose
      if [[ $1 == $pattern ]]; then package=$name; set +f; return; fi
    done
  done
  set +f
}

# --- Target links ------------------------------------------------------------------------
# A folder is a module; its CMakeLists.txt may split off another one, whose files are then those
# it lists (and the headers of the same name).
# links_public[m], links_all[m], links_test[m]: modules that m links; owner[folder/stem]: whose
# file it is where that is not the folder's own module.
declare -A links_public links_all links_test has_target owner
for module in "${order[@]}"; do
  links_public[$module]=" $module " links_all[$module]=" $module " links_test[$module]=" "
done

check_lists() {
  local folder=$1 lists=src/watersky/$1/CMakeLists.txt module=$1 section='' word other words
  read -r -d '' -a words < <(sed 's/#.*//; s/\$<BUILD_INTERFACE:\([^>]*\)>/\1/g; s/)/ ) /g; s/(/ ( /g' \
    "$lists") || true
  for word in "${words[@]}"; do
    case $word in
      '(') continue ;;
      ')') section='' module=$folder; continue ;;
      watersky_module) section=NAME; continue ;;
      SOURCES | LINKS | PRIVATE_LINKS | TESTS | TEST_LINKS) section=$word; continue ;;
      target_link_libraries) section=LINKS; continue ;;
    esac
    case $section in
      NAME)
        module=$word
        if [[ -z ${below[$module]:-} ]]; then
          fault "$lists: a module $module that is not in $table"
          return
        fi
        has_target[$module]=1
        continue
        ;;
      SOURCES | TESTS)
        owner[$folder/${word%.cpp}]=$module
        continue
        ;;
      LINKS | PRIVATE_LINKS | TEST_LINKS) ;;
      *) continue ;;
    esac
    case $word in
      PUBLIC | PRIVATE | INTERFACE | "watersky_$module") continue ;;
      watersky::* | watersky_*)
        other=${word#watersky}
        other=${other#::}
        other=${other#_}
        if [[ $section == TEST_LINKS ]]; then
          links_test[$module]+="$other "
        elif [[ ${below[$module]} != *" $other "* ]]; then
          fault "$lists: links $word, but $module may not include $other"
        else
          # What it links stands above it in the table, so its own sets are complete.
          links_all[$module]+="${links_public[$other]}"
          [[ $section != LINKS ]] || links_public[$module]+="${links_public[$other]}"
        fi
        ;;
      *)
        [[ $section != TEST_LINKS ]] || continue
        package_of_target "$word"
        if [[ -z $package ]]; then
          fault "$lists: links $word, which is nobody's in packages.txt"
        elif [[ $package == system || " ${open[$module]} " == *" $package "* ]]; then
          :
        elif [[ $section == PRIVATE_LINKS && " ${uses[$module]} " == *" $package "* ]]; then
          :
        else
          fault "$lists: $section $word, but the table does not give $module $package" \
            "$([[ " ${uses[$module]} " != *" $package "* ]] || echo '(only as PRIVATE_LINKS)')"
        fi
        ;;
    esac
  done
}
for module in "${order[@]}"; do
  [[ ! -f src/watersky/$module/CMakeLists.txt ]] || check_lists "$module"
done

# Sets `whose` to the module of a file or include, given as folder/path without its ending.
module_of() { whose=${owner[$1]:-${1%%/*}}; }

# --- Includes ----------------------------------------------------------------------------
for folder in src/watersky/*/; do
  module=$(basename "$folder")
  [[ -n ${below[$module]:-} ]] || fault "$folder: a module that is not in $table"
done

check_file() {
  local module=$1 file=$2 folder=$3 kind=source line number include other package whose
  case $file in
    *_test.cpp | */test_* | */testing/*) kind='test' ;;
    */detail/*) kind=source ;;
    *.hpp) kind=header ;;
  esac
  while IFS=: read -r number line; do
    if [[ $line =~ ^[[:space:]]*\#[[:space:]]*include[[:space:]]*[\"\<]([^\"\>]+)([\"\>]) ]]; then
      include=${BASH_REMATCH[1]}
    else
      continue
    fi
    if [[ $include == watersky/* ]]; then
      module_of "$(sed 's/^watersky\///; s/\.[a-z]*$//' <<< "$include")"
      other=$whose
      if [[ $include == */detail/* ]]; then
        if [[ $include != "watersky/$folder/"* ]]; then
          fault "$file:$number: $include is private to $other"
        elif [[ $kind == header ]]; then
          fault "$file:$number: a public header needs $include, which is not installed"
        fi
      fi
      [[ $other != "$module" ]] || continue
      if [[ $kind == test && ${links_test[$module]} == *" $other "* ]]; then continue; fi
      if [[ ${below[$module]} != *" $other "* ]]; then
        fault "$file:$number: $module may not include $other ($include)"
      elif [[ -n ${has_target[$module]:-} ]]; then
        if [[ $kind == header && ${links_public[$module]} != *" $other "* ]]; then
          fault "$file:$number: includes $include, but $module's LINKS do not reach $other"
        elif [[ ${links_all[$module]} != *" $other "* ]]; then
          fault "$file:$number: includes $include, but $module does not link $other"
        fi
      fi
      continue
    fi
    if [[ ${BASH_REMATCH[2]} == '"' ]]; then
      if [[ $kind == test && $include == support/* ]]; then continue; fi  # tests/support
      fault "$file:$number: write \"watersky/…/$include\" in full"
      continue
    fi
    [[ $kind != test ]] || continue
    [[ $include == *.* || $include == */* ]] || continue  # the standard library
    package_of_include "$include"
    if [[ -z $package ]]; then
      fault "$file:$number: <$include> is nobody's in packages.txt"
    elif [[ $package == system || " ${open[$module]} " == *" $package "* ]]; then
      :
    elif [[ " ${uses[$module]} " == *" $package "* ]]; then
      [[ $kind != header ]] ||
        fault "$file:$number: $module keeps $package to its sources; <$include> is in a header"
    else
      fault "$file:$number: $module may not use $package (<$include>)"
    fi
  done < <(grep -nE '^[[:space:]]*#[[:space:]]*include' -- "$file" || true)
}

checked=0
while IFS= read -r -d '' file; do
  folder=${file#src/watersky/}
  module_of "${folder%.*}"
  folder=${folder%%/*}
  [[ -n ${below[$whose]:-} ]] || continue
  check_file "$whose" "$file" "$folder"
  checked=$((checked + 1))
done < <(find src/watersky -mindepth 2 \( -name '*.hpp' -o -name '*.cpp' \) -print0 | sort -z)
[[ $checked -gt 0 ]] || fault "src/watersky holds no source"

# Programs that others learn from keep out of detail/ as well.
for folder in apps examples; do
  [[ -d $folder ]] || continue
  while IFS= read -r hit; do
    fault "$hit: private to its module"
  done < <(grep -rnE '#[[:space:]]*include[[:space:]]*["<]watersky/[^">]*/detail/' "$folder" || true)
done

# --- Headers -----------------------------------------------------------------------------
while IFS= read -r -d '' file; do
  IFS= read -r first < "$file" || true
  [[ ${first:-} == '// SPDX-License-Identifier: MIT' ]] ||
    fault "$file:1: begins without // SPDX-License-Identifier: MIT"
  grep -q '^#pragma once$' -- "$file" || fault "$file: has no #pragma once"
done < <(find src/watersky -name '*.hpp' -print0 | sort -z)

# --- The order ---------------------------------------------------------------------------
built=$(sed -nE 's/^foreach\(module (.*)\)$/\1/p' CMakeLists.txt)
expected=
for module in "${order[@]}"; do
  [[ " $built " != *" $module "* ]] || expected+="$module "
done
[[ "$(tr -s ' ' <<< "$built ")" == "$expected" ]] ||
  fault "CMakeLists.txt: builds \"$built\"; the table's order is \"${expected% }\""

if [[ $faults -gt 0 ]]; then
  echo "$faults faults"
  exit 1
fi
echo "$checked files keep the walls of $table"
