# The real CT that ./run shows without one of the user's own: the head of Debian's package
# invesalius-examples, given a MetaImage header in place of InVesalius' own. Sourced, not run.

readonly DEMO_PROJECT=/usr/share/doc/invesalius-examples/examples/Cranium.inv3

# A value of the project's description: the lines after a key.
project_values() {
  grep -A "$3" "<key>$2</key>" "$1" | sed -n 's/.*<\(integer\|real\)>\(.*\)<.*/\2/p' | tr '\n' ' '
}

# Writes $1/head.mhd.
make_demo_ct() {
  mkdir -p "$1"
  tar xzf "$DEMO_PROJECT" -C "$1" --strip-components=1 --wildcards '*/main.plist' '*/matrix.dat'
  local slices rows columns
  read -r slices rows columns <<<"$(project_values "$1/main.plist" shape 4)"
  # The columns run to the patient's right and the rows to the front; MetaImage counts left and back.
  cat >"$1/head.mhd" <<EOF
ObjectType = Image
NDims = 3
BinaryData = True
BinaryDataByteOrderMSB = False
CompressedData = False
TransformMatrix = -1 0 0 0 -1 0 0 0 1
Offset = 0 0 0
ElementSpacing = $(project_values "$1/main.plist" spacing 4)
DimSize = $columns $rows $slices
ElementType = MET_SHORT
ElementDataFile = matrix.dat
EOF
}
