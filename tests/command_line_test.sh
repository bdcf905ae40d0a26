#!/usr/bin/env bash
# SPDX-FileCopyrightText: 2026 The Morgagni authors
# SPDX-License-Identifier: BSD-3-Clause

# What a user meets at the command line: exit codes (1: it failed, 2: wrong usage) and one sentence.
# Usage: command_line_test.sh MORGAGNI
set -u
morgagni=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
failures=0

# expect CODE TEXT ARGUMENTS...: the program ends with CODE and prints TEXT.
expect() {
  local code=$1 text=$2 output
  shift 2
  output=$("$morgagni" "$@" 2>&1 </dev/null)
  local got=$?
  if [ "$got" != "$code" ] || ! grep -qF -- "$text" <<<"$output"; then
    echo "FAILED: morgagni $*"
    echo "  expected exit $code and \"$text\", got exit $got and:"
    sed 's/^/  | /' <<<"$output"
    failures=$((failures + 1))
  fi
}

expect 0 "Example, from a CT to a live picture" --help
expect 0 "Not a medical device" --help
expect 0 "morgagni 0." --version
for command in prepare serve record document evaluate calibrate self-calibrate pacs doctor; do
  expect 0 "morgagni $command" "$command" --help
done
expect 0 "OpenCL (--device of the icp methods)" doctor
expect 0 '"opencl_devices": [' doctor --json
expect 0 "Range cameras (--camera)" doctor
expect 0 '"range_cameras": [' doctor --json
OCL_ICD_VENDORS="$scratch/none" expect 0 "there is no OpenCL device: install a driver" doctor
OCL_ICD_VENDORS="$scratch/none" expect 0 '"opencl_devices": []' doctor --json
expect 0 "ENUM:auto, centred or ct" evaluate recording --help
expect 0 "ENUM:lps or ras" prepare --help
expect 0 "ENUM:filled or shell" document --help
expect 0 "morgagni evaluate bound" evaluate bound --help
expect 0 "morgagni evaluate self-calibration" evaluate self-calibration --help
expect 0 "morgagni evaluate starts" evaluate starts --help
expect 0 "morgagni evaluate studies" evaluate studies --help
expect 0 "morgagni pacs query" pacs query --help
expect 0 "morgagni pacs get" pacs get --help
expect 0 "morgagni pacs serve" pacs serve --help
expect 2 "subcommand is required" pacs
expect 2 "--out" pacs get https://pacs.example/dicom-web
expect 2 "--by" pacs get dicom://A@b --out "$scratch/ct" --by post
expect 2 "--tries" pacs get dicom://A@b --out "$scratch/ct" --tries 0
expect 2 "--max-object-mb" pacs get dicom://A@b --out "$scratch/ct" --max-object-mb 0
expect 2 "--user excludes --token-file" pacs query https://pacs.example/x --user anna --token-file t
expect 1 "\"Müller\" is not UTF-8" pacs query dicom://A@127.0.0.1:1 --patient-name $'M\xfcller'
expect 1 "is not UTF-8" pacs serve --cases "$scratch"/$'f\xe4lle'
expect 1 "not a way to a PACS" pacs query ftp://pacs.example
expect 1 "AE title of the PACS is missing" pacs query dicom://pacs.example:104
expect 1 "1 to 16" pacs query dicom://A@pacs.example --aet "MORGAGNI AT THE INSTITUTE"
expect 1 "a user goes to --user" pacs query https://anna:geheim@pacs.example/dicom-web
expect 1 "--date is" pacs query dicom://A@127.0.0.1:1 --date 31.01.2026
expect 1 "--study is a UID" pacs query dicom://A@127.0.0.1:1 --study ../../etc
expect 1 "nowhere.txt" pacs query http://127.0.0.1:1/x --user anna --password-file "$scratch/nowhere.txt"
expect 1 "belong together" pacs query dicoms://A@127.0.0.1:1 --ca x.pem --key my.key
expect 1 "refused" pacs query dicom://A@127.0.0.1:1
expect 1 "cannot listen on 203.0.113.1" pacs serve --cases "$scratch/received" --listen 203.0.113.1
expect 1 "not an address in numbers" pacs serve --cases "$scratch/received" --listen localhost
expect 1 "--max-associations must be 1 to 64" pacs serve --cases "$scratch/received" --max-associations 0
export MORGAGNI_CAMERAS_DIR="$scratch/cameras"
expect 0 "none: the cameras' own words are believed" doctor
expect 0 "print at 100 %" calibrate board --out "$scratch/board.pdf"
expect 1 "one number must be odd" calibrate board --board chessboard:8x6:30 --out "$scratch/board.pdf"
expect 1 "--camera NAME or --images DIR, one of the two" calibrate
expect 1 "--page needs a live camera" calibrate --page
expect 1 "no such folder" calibrate --images "$scratch/missing"
expect 1 "the simulated body holds no board" calibrate --camera simulated:
expect 2 "--views" calibrate --camera simulated-board: --views 3
expect 1 "is unknown" calibrate check --camera nothing:
expect 2 "subcommand is required"
expect 2 "subcommand is required" evaluate
expect 2 "--case" prepare ct.nii
for option in --align-series --structure-frame=ras --total-segmentator --port=0 --web=web; do
  expect 2 "${option%=*} requires" prepare ct.nii --case "$scratch/case" "$option"
done
expect 2 "--nonsense" serve --case "$scratch" --nonsense
expect 2 "--frames" record --case "$scratch" --out "$scratch/r" --frames 0

expect 1 "nowhere.nii" prepare "$scratch/nowhere.nii" --case "$scratch/case"
expect 1 "nowhere.nii" prepare "$scratch/nowhere.nii" --list-series
expect 2 "--list-series" prepare "$scratch/nowhere.nii" --list-series --series 2
expect 1 "nowhere.nii" prepare "$scratch/nowhere.nii" --preview "$scratch/body.png"
expect 1 "num_vertices" prepare "$scratch/nowhere.nii" --case "$scratch/case" --vertices 3
mkdir "$scratch/pictures" && touch "$scratch/pictures/holiday.jpg"
expect 1 "is no case" prepare "$scratch/nowhere.nii" --case "$scratch/pictures"
expect 1 "is no prepared case" serve --case "$scratch/pictures"
expect 1 "is no prepared case" self-calibrate --case "$scratch/pictures"
expect 2 "--views" self-calibrate --case "$scratch/pictures" --views 19
expect 1 "no such case folder" serve --case "$scratch/missing"
expect 1 "--method must be field, icp, trimmed-icp, anisotropic-icp" serve --case "$scratch/missing" --method magic
expect 1 "--start-side must be" serve --case "$scratch/missing" --start-side top
expect 1 "no such case folder" evaluate recording "$scratch" --case "$scratch/missing" --truth t --targets t
expect 1 "no such case folder" evaluate starts --case "$scratch/missing"
expect 2 "--gate" serve --case "$scratch/missing" --gate guess
expect 2 "--start" serve --case "$scratch/missing" --start magic
expect 1 "no such case folder" evaluate bound --case "$scratch/missing"
expect 1 "no such case folder" evaluate studies --case "$scratch/missing" --out "$scratch/s"
expect 2 "--poses" evaluate studies --case "$scratch/missing" --out "$scratch/s" --poses 0
expect 1 "no such case folder" document --case "$scratch/missing"
expect 1 '--formats must be of glb, obj, ply, stl, 3mf, viewer, pdf, got "docx"' document --case "$scratch/missing" --formats docx
expect 1 "wall_mm must be 0.5 to 20, got 0" document --case "$scratch/missing" --wall-mm 0
expect 2 "--print" document --case "$scratch/missing" --print solid
expect 1 "no such case folder" record --case "$scratch/missing" --out "$scratch/r"
expect 1 "--case is needed" record --out "$scratch/r.mcap"
expect 1 "nowhere.mcap" record --camera "mcap:$scratch/nowhere.mcap" --out "$scratch/r.mcap"
expect 1 "camera 'webcam:' is unknown" record --camera webcam: --out "$scratch/r.mcap"
expect 1 "nowhere.mcap" record --camera "mcap:$scratch/nowhere.mcap" --out "$scratch/r.mkv"
expect 1 "needs a port" record --camera push: --out "$scratch/r.mcap"
expect 1 "there is no /dev/no_video" record --camera v4l2:/dev/no_video --out "$scratch/r.mcap"
expect 2 "--color" record --camera "mcap:$scratch/nowhere.mcap" --out "$scratch/r.mcap" --color gray
# A camera that fails (the fourth picture and all after it are cut off) ends a recording, which keeps the three before.
python3 - "$scratch/cut" <<'PYTHON'
import json, os, struct, sys, zlib

def png(bits, color, row):
    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
    head = struct.pack(">IIBBBBB", 160, 120, bits, color, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(row * 120)) + chunk(b"IEND", b"")

os.makedirs(sys.argv[1])
os.chdir(sys.argv[1])
depth = png(16, 0, b"\0" + struct.pack(">160H", *range(700, 860)))
color = png(8, 2, b"\0" + bytes(480))
for name, picture in ("depth", depth), ("rgb", color):
    os.mkdir(name)
    with open(name + ".txt", "w") as list_file:
        for i in range(20):
            list_file.write(f"{i / 10:.6f} {name}/{i}.png\n")
            with open(f"{name}/{i}.png", "wb") as file:
                file.write(picture if name == "rgb" or i < 3 else picture[:90])
with open("intrinsics.json", "w") as file:
    json.dump({"fx": 130, "fy": 130, "cx": 79.5, "cy": 59.5, "width": 160, "height": 120, "depth_scale": 1000}, file)
PYTHON
for out in kept kept.mkv kept.mcap; do
  expect 1 "3 frames" record --camera "tum:$scratch/cut,speed=full" --out "$scratch/$out"
done
expect 0 "3 frames" record --camera "tum:$scratch/kept,speed=full" --out "$scratch/again.mcap"
expect 0 "3 frames" record --camera "mcap:$scratch/kept.mcap,speed=full" --out "$scratch/again.mkv"
[ -s "$scratch/kept.mkv" ] || { echo "FAILED: no Matroska file was kept"; failures=$((failures + 1)); }

[ ! -e "$scratch/case" ] || { echo "FAILED: a refused preparation left its folder"; failures=$((failures + 1)); }

if [ "$failures" != 0 ]; then exit 1; fi
echo "the command line answers as it should"
