#!/usr/bin/env bash
# Checks whether a change to the program changes a byte of any result.
#
#   scripts/regression.sh BINARY     runs all subcommands on generated inputs, and prints the SHA-256 and
#                                    the name of every file and text produced
#   scripts/regression.sh OLD NEW    runs both, and prints the names whose hashes differ; exit code 1
#                                    if there are any
#
# With UVGRAFT_REGRESSION_REAL=1, and UVGRAFT_DATA naming a folder with FLAME's and SMPL-X's meshes and
# textures, it runs further commands on these; their names begin with `real/`. If
# UVGRAFT_REGRESSION_KEEP names a folder, the results are kept there for inspection.
#
# Commands that need a feature the binary was built without are listed on stderr and skipped. Not covered
# are `view`, whose page is bundled by npm, `bench`, which only measures times, and pair files, whose
# format may change. Results whose names begin with `processor/` may differ between processors: the crate
# behind SSIMULACRA 2 rounds according to its vector width.
#
# Needs bash and coreutils.
set -euo pipefail
shopt -s globstar nullglob
export LC_ALL=C

if [ $# -lt 1 ] || [ $# -gt 2 ]; then
    echo "usage: scripts/regression.sh BINARY [OTHER_BINARY]" >&2
    exit 2
fi

temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT
trap 'kill $(jobs -p) 2>/dev/null; exit 130' HUP INT TERM

# --- Running the binary ---------------------------------------------------------------------------
#
# In arguments, @ stands for out/NAME. All files below out/ are hashed at the end.

# invoke NAME ARGS...: runs a command; its output goes to log/NAME.out and log/NAME.err, its exit code
# to `code`.
invoke() {
    local name=$1
    shift
    mkdir -p "out/${name%/*}" "log/${name%/*}"
    code=0
    "$program" "${@//@/out/$name}" >"log/$name.out" 2>"log/$name.err" </dev/null || code=$?
    commands=$((commands + 1))
}

# run NAME ARGS...: a command that succeeds; if `needs` is set to a cargo feature, it may also fail for
# lack of that feature.
run() {
    invoke "$@"
    if [ $code = 2 ] && [ -n "${needs:-}" ] && [[ $(<"log/$1.err") == *feature*"\`$needs\`"* ]]; then
        echo "skipped: $1: the binary was built without the feature $needs" >&2
    elif [ $code != 0 ]; then
        complain "$@"
    fi
}

# told NAME ARGS...: a command that succeeds, and whose output is hashed.
told() {
    run "$@"
    [ $code != 0 ] || cp "log/$1.out" "out/$1.txt"
}

# refused NAME ARGS...: a command that fails, and whose message and exit code are hashed.
refused() {
    invoke "$@"
    [ $code != 0 ] || complain "$@"
    { cat "log/$1.err"; echo "exit code $code"; } >"out/$1.txt"
}

complain() {
    { echo "regression: exit code $code of $1: uvgraft ${*:2}"; cat "log/$1.err"; } >&2
    failed=1
}

# --- Inputs that need no binary -------------------------------------------------------------------

# le BYTES NUMBER: the number in little-endian order, escaped for printf's %b.
le() {
    local k text=
    for ((k = 0; k < $1; k++)); do
        printf -v text '%s\\x%02x' "$text" $(($2 >> 8 * k & 255))
    done
    echo -n "$text"
}

# tiff NAME WIDTH HEIGHT CHANNELS BITS TEXELS: an uncompressed image; TEXELS are escaped for %b.
tiff() {
    local width=$2 height=$3 channels=$4 bits=$5 k format=1 color=1 alpha=0 depths=
    if [ "$bits" = 32 ]; then format=3; fi
    if [ "$channels" -ge 3 ]; then color=2; fi
    if [ $((channels % 2)) = 0 ]; then alpha=1; fi
    for ((k = 0; k < 4; k++)); do depths+=$(le 2 "$bits"); done
    # Tag, type (3 is 16 bits, 4 is 32 bits), count and value; depths are at byte 8, texels after the
    # directory.
    local entries=(
        "256 3 1 $width" "257 3 1 $height" "258 3 $channels 8" "259 3 1 1" "262 3 1 $color"
        "273 4 1 200" "277 3 1 $channels" "278 3 1 $height"
        "279 4 1 $((width * height * channels * bits / 8))" "339 3 $channels 16"
    )
    if [ "$channels" -le 2 ]; then
        # One or two 16-bit numbers are stored in the directory itself.
        entries[2]="258 3 $channels $((channels == 2 ? bits << 16 | bits : bits))"
        entries[9]="339 3 $channels $((channels == 2 ? format << 16 | format : format))"
    fi
    if [ $alpha = 1 ]; then
        entries=("${entries[@]:0:9}" "338 3 1 2" "${entries[9]}")
    fi
    local head
    head="II*\\x00$(le 4 24)$depths"
    for ((k = 0; k < 4; k++)); do head+=$(le 2 $format); done
    head+=$(le 2 ${#entries[@]})
    local entry tag kind count value
    for entry in "${entries[@]}"; do
        read -r tag kind count value <<<"$entry"
        head+=$(le 2 "$tag")$(le 2 "$kind")$(le 4 "$count")$(le 4 "$value")
    done
    head+=$(le 4 0)
    # From byte 24: a count, the entries, an offset; the texels from byte 200.
    for ((k = 24 + 2 + 12 * ${#entries[@]} + 4; k < 200; k++)); do head+='\x00'; done
    printf '%b%b' "$head" "$6" >"$1"
}

# noise NAME WIDTH HEIGHT CHANNELS BITS: a pseudo-random value for each texel; floats from 0.125 to 2.
noise() {
    local k texels= state=7 count=$(($2 * $3 * $4)) octets
    for ((k = 0; k < count; k++)); do
        state=$(((state * 1664525 + 1013904223) & 0xffffffff))
        case $5 in
            8) printf -v octets '\\x%02x' $((state >> 24)) ;;
            16) printf -v octets '\\x%02x\\x%02x' $((state >> 16 & 255)) $((state >> 24)) ;;
            32) printf -v octets '\\x00\\x%02x\\x%02x\\x%02x' $((state >> 8 & 255)) \
                    $((state >> 16 & 255)) $((0x3e + (state >> 24 & 1))) ;;
        esac
        texels+=$octets
    done
    tiff "$1" "$2" "$3" "$4" "$5" "$texels"
}

# disc NAME SIDE X Y RADIUS: white on black.
disc() {
    local x y texels=
    for ((y = 0; y < $2; y++)); do
        for ((x = 0; x < $2; x++)); do
            if (((x - $3) ** 2 + (y - $4) ** 2 < $5 ** 2)); then texels+='\xff'; else texels+='\x00'; fi
        done
    done
    tiff "$1" "$2" "$2" 1 8 "$texels"
}

# normals NAME SIDE: waves that tilt by up to 30 degrees.
normals() {
    local x y octets texels=
    for ((y = 0; y < $2; y++)); do
        for ((x = 0; x < $2; x++)); do
            printf -v octets '\\x%02x\\x%02x\\xe8' $((98 + (x * 7 + y) % 61)) $((98 + (y * 5 + x) % 59))
            texels+=$octets
        done
    done
    tiff "$1" "$2" "$2" 3 8 "$texels"
}

# A bumpy sheet of 8 by 8 quads of 10 mm, one of which, in a corner, has no area in UV, as sheet.obj; and
# as strip.obj a longer one that contains it, of triangles with other diagonals, some of them wound the
# other way, in a layout rotated by 90 degrees. sheet.txt is the vertex map; the last row is unmapped.
sheets() {
    local x y a b c d at
    {
        for ((y = 0; y <= 8; y++)); do for ((x = 0; x <= 8; x++)); do
            echo "v $((10 * x)) $((10 * y)) $(((x * y + x) % 7))"
            printf 'vt 0.%03d 0.%03d\n' $((100 + 100 * x)) $((100 + 97 * y))
        done; done
        for ((y = 0; y < 8; y++)); do for ((x = 0; x < 8; x++)); do
            a=$((9 * y + x + 1)) b=$((9 * y + x + 2)) c=$((9 * y + x + 11)) d=$((9 * y + x + 10))
            if ((x + y == 0)); then
                echo "f $a/$a $b/$a $c/$a $d/$a"
            else
                echo "f $a/$a $b/$b $c/$c $d/$d"
            fi
        done; done
    } >sheet.obj
    {
        for ((y = 0; y <= 8; y++)); do for ((x = 0; x <= 12; x++)); do
            at=$((x - 2))
            echo "v $((10 * at)) $((10 * y)) $(((at * y + at + 14) % 7))"
            printf 'vt 0.%03d 0.%03d\n' $((50 + 103 * y)) $((950 - 75 * x))
        done; done
        for ((y = 0; y < 8; y++)); do for ((x = 0; x < 12; x++)); do
            a=$((13 * y + x + 1)) b=$((13 * y + x + 2)) c=$((13 * y + x + 15)) d=$((13 * y + x + 14))
            if ((y == 5)); then
                printf 'f %s/%s %s/%s %s/%s\n' $c $c $b $b $a $a $d $d $c $c $a $a
            elif (((x + y) % 2)); then
                printf 'f %s/%s %s/%s %s/%s\n' $a $a $b $b $d $d $b $b $c $c $d $d
            else
                printf 'f %s/%s %s/%s %s/%s\n' $a $a $b $b $c $c $a $a $c $c $d $d
            fi
        done; done
    } >strip.obj
    for ((y = 0; y <= 8; y++)); do for ((x = 0; x <= 8; x++)); do
        echo $((y < 8 ? 13 * y + x + 2 : -1))
    done; done >sheet.txt
}

make_inputs() {
    noise noise.tif 64 64 3 8
    noise wide.tif 150 40 3 8
    noise rgba.tif 64 64 4 8
    noise grey.tif 64 64 1 8
    noise grey_alpha.tif 64 64 2 8
    noise deep.tif 64 64 3 16
    noise deep_rgba.tif 48 48 4 16
    noise deep_grey.tif 64 64 1 16
    noise float.tif 48 48 3 32
    noise float_rgba.tif 48 48 4 32
    noise float_grey.tif 48 48 1 32
    disc disc.tif 64 32 26 17
    disc body_disc.tif 64 9 10 8
    normals normals.tif 64
    normals body_normals.tif 96
    sheets
}

# where OBJ CONDITION: the vertices that meet a condition on the strings $x, $y and $z.
where() {
    local kind x y z id=0
    while read -r kind x y z; do
        [ "$kind" = v ] || break
        if eval "[[ $2 ]]"; then echo $id; fi
        id=$((id + 1))
    done <"$1"
}

# array NAME VERTICES: 16-bit vertex indices as an NPY file.
array() {
    local vertex count=0 octets=
    for vertex in $2; do
        octets+=$(le 2 "$vertex")
        count=$((count + 1))
    done
    printf '\x93NUMPY\x01\x00\x76\x00%-117s\n' "{'descr': '<u2', 'fortran_order': False, 'shape': ($count,), }" >"$1"
    printf '%b' "$octets" >>"$1"
}

# Parts of the demo's head and body, which are in metres, Y up, Z to the front.
make_parts() {
    local front top back
    front=$(where head.obj '$z != -*')
    top=$(where head.obj '$y > 1.67')
    back=$(where head.obj '$z == -*')
    echo "$front" >front.txt
    array top.npy "$top"
    printf '{"front": [%s], "top": [%s], "back": [%s]}' \
        "${front//$'\n'/,}" "${top//$'\n'/,}" "${back//$'\n'/,}" >groups.json
    where body.obj '$z != -* && $y > 1.55' >body_face.txt
}

# --- The commands ---------------------------------------------------------------------------------

demo() {
    run demo/256 demo --size 256 -o @
    cp out/demo/256/head_to_body.uvpair my.uvpair
    cp out/demo/256/{head.obj,body.obj,head_to_body.npy,face.png,wave.npz,avatar.glb,avatar.vrm} .
    cp out/demo/256/body_base.png body.png
    cp out/demo/256/body_darker.png darker.png
    cp out/demo/256/body_with_face.png whole.png
    make_parts
}

pairs() {
    told pair/body pair head.obj body.obj --vertex-map head_to_body.npy -o @.uvpair --json --preview @.png --source-size 300x200 --target-size 512
    told pair/sheet pair sheet.obj strip.obj --vertex-map sheet.txt -o @.uvpair --json --preview @.png --note 'two sheets'
    cp out/pair/sheet.uvpair sheet.uvpair
    told inspect/body inspect my.uvpair --json --preview @.png --source-size 64 --target-size 99x201
    told inspect/sheet inspect sheet.uvpair --json --source-size 128 --target-size 100x60
}

maps() {
    run map/forward map my.uvpair --size 160x97 -o @.npy
    run map/reverse map my.uvpair --size 90 --reverse --gutter 3 -o @.npy
    run map/left map my.uvpair --size 200 --prefer left --gutter 0 --threads 1 -o @.npy
    run map/right map my.uvpair --size 200 --prefer right --gutter 40 --threads 3 -o @.npy
    run map/sheet map sheet.uvpair --size 75x131 -o @.npy
    run map/sheet_reverse map sheet.uvpair --size 131x75 --reverse -o @.npy
}

filters() {
    local filter
    for filter in nearest bilinear catmull-rom lanczos3; do
        run $filter/forward transfer my.uvpair face.png --onto body.png --filter $filter -o @.png
        run $filter/reverse transfer my.uvpair whole.png --onto face.png --reverse --filter $filter --size 151x210 -o @.png
        run $filter/deep transfer my.uvpair deep.tif --onto body.png --filter $filter -o @.png
        run $filter/float transfer my.uvpair float.tif --onto body.png --filter $filter --size 99 -o @.exr
        run $filter/rgba transfer my.uvpair rgba.tif --onto body.png --filter $filter -o @.png
        run $filter/grey transfer my.uvpair grey.tif --filter $filter --size 120 --onto '#777' -o @.png
        run $filter/shrunk transfer my.uvpair face.png --onto '#102030' --filter $filter --size 61x47 -o @.png
        run $filter/linear_light transfer my.uvpair face.png --onto '#80808080' --filter $filter --size 77 --linear-light -o @.png
        run $filter/data transfer sheet.uvpair noise.tif --filter $filter --size 80x110 --data -o @.png
        if [ $filter = nearest ]; then continue; fi
        run $filter/fit transfer my.uvpair whole.png --onto '#808080' --reverse --fit --fit-steps 5 --filter $filter --size 64 -o @.png
    done
}

formats() {
    local kind
    for kind in noise rgba grey grey_alpha deep deep_rgba deep_grey float float_rgba float_grey; do
        run format/$kind transfer sheet.uvpair $kind.tif --size 90x70 -o @.tif
    done
    run format/deep_png transfer my.uvpair deep.tif --onto body.png -o @.png
    run format/deep_alpha_png transfer my.uvpair deep_rgba.tif --size 70 -o @.png
    run format/float_png transfer my.uvpair float_rgba.tif --onto '#456' --size 70 -o @.png
    run format/compressed transfer my.uvpair face.png --onto body.png --compress -o @.png
    run format/compressed_deep transfer my.uvpair deep_rgba.tif --onto body.png --compress -o @.png
    run format/jpeg transfer my.uvpair face.png --onto body.png -o @.jpg
    run format/jpeg_40 transfer my.uvpair face.png --onto body.png --quality 40 -o @.jpeg
    run format/webp transfer my.uvpair rgba.tif --size 128 -o @.webp
    run format/webp_compressed transfer my.uvpair face.png --onto body.png -o @.webp
    run format/tiff_compressed transfer my.uvpair deep.tif --size 128 --compress -o @.tiff
    run format/exr transfer my.uvpair face.png --onto body.png -o @.exr
    run format/exr_compressed transfer my.uvpair float.tif --size 80 --compress -o @.exr
    # Reads the results again, as the texture and as the base.
    run format/jpeg_again transfer my.uvpair out/format/jpeg.jpg --onto face.png --reverse -o @.png
    run format/webp_again transfer my.uvpair out/format/webp.webp --onto out/format/exr.exr --size 128 --reverse -o @.tif
    run format/tiff_again transfer my.uvpair out/format/deep_rgba.tif --onto out/format/jpeg_40.jpeg -o @.png
    run format/exr_again transfer my.uvpair out/format/exr.exr --onto out/format/webp_compressed.webp -o @.png
    run format/grey_onto_deep transfer my.uvpair grey.tif --onto out/format/deep_alpha_png.png -o @.png
}

options() {
    run option/nothing_beneath transfer my.uvpair face.png --size 128 -o @.png
    run option/clear_base transfer my.uvpair face.png --onto '#80a04000' --size 128 -o @.png
    run option/clear_onto_clear transfer my.uvpair rgba.tif --onto '#80a04040' --size 128 --linear-light -o @.png
    run option/odd_sizes transfer my.uvpair wide.tif --onto body.png --size 333x77 --mask @_mask.png -o @.png
    run option/enlarged transfer my.uvpair noise.tif --onto '#808080' --size 611x403 -o @.png
    run option/large transfer my.uvpair whole.png --onto '#808080' --size 1500x1300 --reverse --mask @_mask.png -o @.png
    run option/large_compressed transfer my.uvpair noise.tif --onto body.png --size 1201x907 --compress -o @.png
    run option/gutter_0 transfer my.uvpair face.png --onto body.png --gutter 0 --mask @_mask.png -o @.png
    run option/gutter_3 transfer my.uvpair face.png --onto body.png --gutter 3 -o @.png
    run option/gutter_40 transfer my.uvpair noise.tif --onto body.png --gutter 40 --reverse -o @.png
    run option/left transfer my.uvpair noise.tif --onto body.png --prefer left --mask @_mask.png -o @.png
    run option/right transfer my.uvpair noise.tif --onto body.png --prefer right -o @.png
    run option/average transfer my.uvpair noise.tif --onto body.png --overlap average -o @.png
    run option/average_deep transfer my.uvpair deep_rgba.tif --onto body.png --overlap average --prefer left -o @.png
    run option/average_data transfer my.uvpair noise.tif --size 200 --overlap average --data -o @.png
    run option/data_deep transfer my.uvpair deep_grey.tif --size 128 --data --filter lanczos3 -o @.png
    run option/data_float transfer my.uvpair float_rgba.tif --size 60 --data -o @.exr
    run option/fit transfer my.uvpair whole.png --onto '#808080' --size 200 --reverse --fit -o @.png
    run option/fit_alpha transfer my.uvpair rgba.tif --size 90x70 --fit --fit-steps 8 -o @.png
    run option/fit_deep transfer my.uvpair deep.tif --onto body.png --fit --fit-steps 3 --linear-light --threads 1 -o @.png
    run option/fit_left transfer my.uvpair noise.tif --onto body.png --fit --prefer left --gutter 2 -o @.png
    run option/fit_sheet transfer sheet.uvpair float_grey.tif --size 99x50 --reverse --fit --data -o @.tif
    run option/sheet transfer sheet.uvpair noise.tif --onto '#808080' --size 101x203 --mask @_mask.png -o @.png
    run option/sheet_reverse transfer sheet.uvpair wide.tif --onto '#808080' --size 64 --reverse --gutter 2 -o @.png
    run option/one_thread transfer my.uvpair deep.tif --onto body.png --size 900x700 --threads 1 -o @.png
    run option/three_threads transfer my.uvpair deep.tif --onto body.png --size 900x700 --threads 3 -o @.png
}

several() {
    mkdir sources
    cp face.png noise.tif grey_alpha.tif deep.tif out/format/jpeg.jpg out/format/exr.exr out/format/webp.webp sources
    run several/folder transfer my.uvpair sources --onto body.png -o @
    run several/jobs transfer my.uvpair sources --onto body.png --jobs 3 --threads 2 --memory 300M --mask @_mask.png -o @
    run several/one_job transfer my.uvpair sources --size 100x120 --jobs 1 --threads 1 --format png --feather 1cm --unit m -o @
    run several/listed transfer my.uvpair face.png noise.tif --onto '#123456' --size 64 --format webp -o @
    run several/skipped transfer my.uvpair face.png noise.tif --onto body.png --skip-existing --format png -o @
}

materials() {
    local maps='--map albedo=face.png --map normal=normals.tif --map roughness=deep_grey.tif --map displacement=float_grey.tif'
    local bases='--onto albedo=body.png --onto normal=body_normals.tif --onto roughness=grey.tif --onto displacement=#333'
    run material/plain transfer my.uvpair $maps --size 160 -o @
    run material/based transfer my.uvpair $maps $bases --size 140x150 --unit m --blend membrane --mask @_mask.png -o @
    run material/reversed transfer my.uvpair $maps --size 90x60 --reverse --threads 3 --jobs 2 -o @
    run material/formats transfer my.uvpair $maps --size 64 --format tif --filter bilinear -o @
    run material/directx transfer my.uvpair --map normal=normals.tif --onto normal=body_normals.tif --normal-y directx -o @
    run material/directx_out transfer my.uvpair --map normal=normals.tif --size 150 --normal-y-out directx -o @
    run material/normals_deep transfer my.uvpair --map normal=deep_rgba.tif --size 80 --filter catmull-rom --overlap average -o @
    run material/normals_float transfer my.uvpair --map normal=float.tif --size 80 --normal-y directx --normal-y-out opengl -o @
    run material/sheet transfer sheet.uvpair --map normal=normals.tif --map ao=grey.tif --map orm=rgba.tif --size 90 --blend feather --unit mm -o @
    run material/sheet_reversed transfer sheet.uvpair --map normal=body_normals.tif --map emissive=noise.tif --size 64 --reverse -o @
}

regions() {
    local region="transfer my.uvpair face.png --onto darker.png --unit m"
    run region/vertices $region --region front.txt --grow 1ring --mask @_mask.png --preview @_preview.png -o @.png
    run region/array $region --region top.npy --grow -3rings --preview @_preview.png -o @.png
    run region/target $region --region target:body_face.txt --mask @_mask.png -o @.png
    run region/painted $region --region disc.tif --mask @_mask.png --preview @_preview.png -o @.png
    run region/painted_target $region --region target:body_disc.tif --mask @_mask.png -o @.png
    run region/groups $region --region 'groups.json#front,top' --exclude 'groups.json#back' --mask @_mask.png -o @.png
    run region/several $region --region 'groups.json#back' --region disc.tif --exclude target:body_disc.tif --mask @_mask.png -o @.png
    run region/wider $region --region disc.tif --grow 12mm --mask @_mask.png -o @.png
    run region/narrower $region --region disc.tif --grow -9mm --feather 4mm --mask @_mask.png -o @.png
    run region/all_but_the_rim $region --grow -0.02m --mask @_mask.png -o @.png
    run region/inches transfer my.uvpair face.png --onto body.png --region disc.tif --grow 0.195in --unit in -o @.png
    run region/centimetres transfer sheet.uvpair noise.tif --onto '#888' --size 90 --grow -1cm --feather 15mm --unit mm -o @.png
    run region/reverse transfer my.uvpair whole.png --onto face.png --reverse --region disc.tif --feather 8mm --unit m --mask @_mask.png -o @.png
    run region/left transfer my.uvpair noise.tif --onto darker.png --region disc.tif --grow 4cm --prefer left --overlap average --unit m -o @.png
}

blends() {
    local blend="transfer my.uvpair face.png --onto darker.png --unit m"
    run blend/none $blend --blend none -o @.png
    run blend/feather $blend --feather 15mm --mask @_mask.png -o @.png
    run blend/feather_deep transfer my.uvpair deep_rgba.tif --onto darker.png --unit m --blend feather -o @.png
    run blend/feather_linear transfer my.uvpair float.tif --onto darker.png --unit m --feather 3cm --linear-light -o @.exr
    run blend/membrane $blend --blend membrane --mask @_mask.png -o @.png
    run blend/membrane_hard $blend --blend membrane --feather 0 --threads 3 -o @.png
    run blend/membrane_source $blend --blend membrane --tone source -o @.png
    run blend/membrane_none $blend --blend membrane --tone none -o @.png
    run blend/membrane_skin $blend --blend membrane --tone source --skin body_disc.tif -o @.png
    run blend/membrane_exr transfer my.uvpair out/format/exr.exr --onto darker.png --unit m --blend membrane --reverse -o @.exr
    run blend/membrane_grey transfer my.uvpair grey.tif --onto grey_alpha.tif --unit m --blend membrane -o @.png
    run blend/membrane_part $blend --blend membrane --region disc.tif --grow 1cm --feather 5mm --filter bilinear -o @.png
    run blend/membrane_reverse transfer my.uvpair out/blend/membrane.png --onto face.png --reverse --unit m --blend membrane --tone source -o @.png
    run blend/membrane_sheet transfer sheet.uvpair noise.tif --onto '#a08070' --size 128 --unit mm --blend membrane --tone source --gutter 0 -o @.png
    run blend/membrane_fit $blend --blend membrane --fit --fit-steps 4 -o @.png
    run blend/membrane_jpeg $blend --blend membrane --size 180x200 --threads 1 -o @.jpg
    run blend/match $blend --match skin -o @.png
    run blend/match_source $blend --match skin --tone source --blend membrane -o @.png
    run blend/match_feather $blend --match skin --tone source --feather 5mm --skin body_disc.tif -o @.png
    run blend/source_mask $blend --source-mask disc.tif --mask @_mask.png -o @.png
    run blend/source_mask_membrane $blend --source-mask disc.tif --blend membrane --region source:front.txt --grow 2rings --mask @_mask.png --preview @_preview.png -o @.png
    run blend/fill $blend --source-mask disc.tif --fill noise.tif -o @.png
    run blend/fill_clear transfer my.uvpair rgba.tif --onto darker.png --unit m --fill face.png --blend membrane --mask @_mask.png -o @.png
    run blend/clear transfer my.uvpair rgba.tif --onto darker.png --unit m --feather 1cm -o @.png
    run blend/onto_nothing transfer my.uvpair face.png --size 200 --unit m --feather 3cm -o @.png
}

measures() {
    local metrics=l1,psnr,ssim,ssim-uniform
    told compare/heatmap compare whole.png body.png --metrics $metrics --json --heatmap @.png
    told compare/masks compare whole.png darker.png --metrics $metrics --json --mask out/option/gutter_0_mask.png --mask out/region/painted_mask.png --threads 3
    told compare/deep compare out/lanczos3/deep.png out/bilinear/deep.png --metrics $metrics --json
    told compare/float compare out/lanczos3/float.exr out/nearest/float.exr --metrics $metrics --json --heatmap @.png
    told compare/same compare face.png face.png --metrics $metrics
    needs=flip told compare/flip compare whole.png darker.png --metrics flip --json --mask out/option/gutter_0_mask.png
    told processor/ssimulacra2 compare whole.png darker.png --metrics ssimulacra2 --json --mask out/option/gutter_0_mask.png

    told seams/body seams my.uvpair out/blend/none.png --json --picture @.png
    told seams/offset seams my.uvpair out/blend/membrane.png --offset 2.5 --worst 3 --json --threads 3
    told seams/distance seams my.uvpair out/blend/feather.png --distance 4mm --unit m --worst 0 --picture @.png
    told seams/region seams my.uvpair out/region/painted.png --region disc.tif --grow 2mm --unit m --json --picture @.png
    told seams/reverse seams my.uvpair out/lanczos3/reverse.png --reverse --exclude source:groups.json#top --json
    told seams/sheet seams sheet.uvpair out/option/sheet.png --distance 2mm --unit mm --json --picture @.png

    run roundtrip/body roundtrip my.uvpair whole.png --via 200 --fit --baseline grid,affine --metrics l1,psnr --repeats 1 -o @
    run roundtrip/filters roundtrip my.uvpair noise.tif --via 97x131 --filter nearest,bilinear,catmull-rom --baseline grid --gutter 3 --metrics l1 --repeats 1 -o @
    run roundtrip/source roundtrip my.uvpair deep_rgba.tif --from source --via 120 --fit --metrics l1 --repeats 1 --threads 3 -o @
    run roundtrip/sheet roundtrip sheet.uvpair float.tif --via 80x60 --baseline affine --filter lanczos3 --metrics psnr --repeats 1 -o @
}

avatars() {
    local avatar="avatar my.uvpair face.png --onto body.png --body demo --unit m"
    local whose="--title Me --author Somebody --author Another --license non-commercial --license-url https://example.org/terms --made-from nothing"
    told avatar/plain $avatar -o @.glb
    run avatar/dark avatar my.uvpair face.png --onto darker.png --body demo --unit m --grow -1cm --region disc.tif --feather 5mm --preview @.png -o @.glb
    run avatar/pasted avatar my.uvpair rgba.tif --onto '#c08a70' --size 128x64 --body demo --unit m --blend none --prefer right --filter bilinear --gutter 4 -o @.glb
    run avatar/filled avatar my.uvpair face.png --onto darker.png --body demo --unit m --source-mask disc.tif --fill face.png --match skin --tone source --skin body_disc.tif --exclude top.npy -o @.glb
    run avatar/motion $avatar --motion wave.npz --fps 10 --texture jpeg -o @.glb
    run avatar/motions $avatar --motion wave.npz --motion wave.npz --fps 0 --texture jpeg --quality 60 --threads 3 -o @.glb
    run avatar/webp $avatar --texture webp --size 100 -o @.glb
    run avatar/author $avatar --author Me --license only-author --texture jpeg -o @.vrm
    run avatar/everything $avatar $whose --size 64 -o @.vrm
    needs=simplify told avatar/quest $avatar --preset quest --author Me --license everyone -o @.vrm
    needs=simplify told avatar/pcvr $avatar --preset pcvr --size 512 --triangles 20000 -o @.glb
    needs=simplify told avatar/web $avatar --preset web --triangles 3000 --motion wave.npz -o @.glb
    told avatar/visionos $avatar --preset visionos --texture png -o @.glb
}

renders() {
    local size="--size 90x120"
    run render/body render avatar.glb $size -o @.png
    run render/head render avatar.vrm $size --camera head --expression jaw_open=0.5 --expression happy -o @.png
    run render/frame render avatar.glb $size --clip walk --frame 0.4 --azimuth -70 --elevation 30 -o @.webp
    run render/posed render avatar.glb $size --pose wave --pose head=0,30,0 --zoom 1.4 --fov 40 --background transparent --no-floor -o @.png
    run render/unlit render avatar.glb $size --unlit --background '#204060' --pose t-pose --threads 3 -o @.jpg
    run render/jpeg_texture render out/avatar/motion.glb $size --frame 1.2 --threads 1 -o @.tif
    run render/webp_texture render out/avatar/webp.glb --size 64 --clip 1 --camera head -o @.png
    run render/turntable render avatar.glb --size 50x70 --turntable 5 --frame 1.2 -o @.gif
    run render/turntable_webp render avatar.vrm --size 40x60 --turntable 4 --fps 6 -o @.webp
    run render/motion render avatar.glb --size 40x60 --motion --clip walk --fps 5 -o @.webp
    run render/frames render avatar.glb --size 40x60 --motion --clip walk --fps 3 -o @.png
    told render/camera render avatar.glb --size 16 --azimuth 33 --print-camera -o @.png
}

refusals() {
    refused error/no_pair transfer face.png face.png --size 64 -o @.png
    refused error/empty_region transfer my.uvpair face.png --size 64 --region disc.tif --exclude disc.tif --unit m -o @.png
    refused error/no_size transfer my.uvpair face.png -o @.png
    refused error/other_mesh pair head.obj sheet.obj --vertex-map head_to_body.npy -o @.uvpair
    refused error/sizes compare face.png noise.tif
    refused error/weights weights import disc.tif
    UVGRAFT_WEIGHTS=my/networks told weights/path weights path
}

# --- Real meshes ----------------------------------------------------------------------------------

real() {
    local head=data/flame_head_template.obj body=data/smplx_addon.obj
    local face=data/flame_face_texture.png mean=data/flame_mean_texture.jpg
    local medium=data/body_medium.jpg light=data/body_light.jpg
    local filter forward
    ln -s "$data" data
    told real/pair pair $head $body --vertex-map data/smplx_flame_vertex_ids.npy -o @.uvpair --json --preview @.png
    cp out/real/pair.uvpair real.uvpair
    for filter in nearest bilinear catmull-rom lanczos3; do
        run real/$filter transfer real.uvpair $face --onto $medium --filter $filter --mask @_mask.png -o @.png
        run real/${filter}_reverse transfer real.uvpair $light --onto $mean --reverse --filter $filter --size 2048 -o @.png
        run real/${filter}_exr transfer real.uvpair $face --onto $medium --filter $filter --linear-light -o @.exr
    done
    run real/deep transfer real.uvpair out/real/lanczos3_exr.exr --onto $face --reverse -o @.png
    run real/fit transfer real.uvpair $medium --onto '#808080' --size 2048 --reverse --fit -o @.png
    run real/left transfer real.uvpair $face --onto $light --prefer left --gutter 3 -o @.png
    run real/right transfer real.uvpair $mean --onto $light --prefer right --overlap average --size 1999x1500 -o @.png
    run real/map map real.uvpair --size 2048 -o @.npy
    run real/map_reverse map real.uvpair --size 1024 --reverse --gutter 40 --prefer left -o @.npy
    forward="transfer real.uvpair $face --onto $medium --unit m"
    run real/feather $forward --feather 15mm --mask @_mask.png -o @.png
    run real/membrane $forward --blend membrane --grow -60mm --mask @_mask.png --preview @_preview.png -o @.png
    run real/membrane_source $forward --blend membrane --tone source -o @.png
    run real/membrane_none $forward --blend membrane --tone none --region disc.tif --grow 1cm -o @.png
    run real/match $forward --match skin -o @.png
    run real/match_narrower $forward --match skin --tone source --grow -60mm -o @.png
    run real/match_source transfer real.uvpair $mean --onto $light --unit m --match skin --tone source --feather 2cm -o @.png
    run real/fill $forward --source-mask disc.tif --fill $mean --blend membrane -o @.png
    run real/material transfer real.uvpair --map albedo=$face --map normal=$mean --map roughness=$face --onto albedo=$light --size 2048 --blend feather --unit m -o @
    run real/normals_reverse transfer real.uvpair --map normal=$medium --reverse --size 1024 --normal-y-out directx -o @
    told real/seams seams real.uvpair $medium --json --picture @.png
    told real/seams_distance seams real.uvpair $face --reverse --distance 3mm --unit m --json
    run real/roundtrip roundtrip real.uvpair $medium --via 1024 --fit --baseline grid,affine --metrics l1 --repeats 1 -o @
    told real/compare compare $medium $light --metrics l1,psnr,ssim,ssim-uniform --json --mask out/real/lanczos3_mask.png --heatmap @.png
}

# --- All of it ------------------------------------------------------------------------------------

# side_by_side GROUP...: runs groups of commands that need none of each other's results, as many at a time
# as there are processors. Each is a process of its own, whose counts come back in a file.
side_by_side() {
    local group count failures
    for group in "$@"; do
        while [ "$(jobs -pr | wc -l)" -ge "$processors" ]; do wait -n || true; done
        (
            commands=0 failed=0
            "$group"
            echo "$commands $failed" >"$temporary/count.$group"
        ) &
    done
    wait
    for group in "$@"; do
        if ! read -r count failures <"$temporary/count.$group"; then
            echo "regression: the group $group has ended early" >&2
            count=0 failures=1
        fi
        commands=$((commands + count))
        failed=$((failed || failures))
    done
}

# hashes BINARY: runs everything in a new folder, and prints hashes and names.
hashes() {
    local file
    # Usage messages contain the name by which the program is called.
    program=$temporary/uvgraft
    ln -s "$1" "$program"
    mkdir "$temporary/work"
    cd "$temporary/work"
    # Ignore any networks that the user has imported.
    export UVGRAFT_WEIGHTS=lpips.safetensors
    commands=0 failed=0
    processors=$(nproc 2>/dev/null || echo 1)
    # Groups use results of those above them; the longest come first.
    side_by_side make_inputs demo
    side_by_side pairs
    side_by_side options filters formats avatars regions materials maps refusals
    side_by_side blends renders several
    side_by_side measures
    if [ -n "$data" ]; then real; fi
    echo "regression: $commands commands" >&2
    if [ -n "$keep" ]; then cp -r out/. "$keep"; fi
    cd out
    for file in **; do
        case $file in
            # Pages contain npm's bundle, and reports of round trips contain times.
            *.uvpair | *.html | */report.md | */report.json) ;;
            *) if [ -f "$file" ]; then sha256sum "$file"; fi ;;
        esac
    done | sort -k 2
    return $failed
}

# differences OLD NEW: the names in two lists of hashes that are missing in one or differ, except for those
# that either binary skipped; the binaries' stderr is in OLD.err and NEW.err.
differences() {
    local hash name line command
    local -A old=() new=()
    while read -r hash name; do old[$name]=$hash; done <"$1"
    while read -r hash name; do new[$name]=$hash; done <"$2"
    while read -r line; do
        case $line in "skipped: "*)
            command=${line#skipped: }
            command=${command%%:*}
            for name in "${!old[@]}" "${!new[@]}"; do
                if [[ $name == "$command".* ]]; then unset "old[$name]" "new[$name]"; fi
            done
            ;;
        esac
    done < <(cat "$1.err" "$2.err")
    {
        for name in "${!old[@]}"; do
            if [ -z "${new[$name]:-}" ]; then
                echo "$name: only the old binary gives it"
            elif [ "${new[$name]}" != "${old[$name]}" ]; then
                echo "$name"
            fi
        done
        for name in "${!new[@]}"; do
            if [ -z "${old[$name]:-}" ]; then echo "$name: only the new binary gives it"; fi
        done
    } | sort
}

for binary in "$@"; do
    if ! [ -f "$binary" ] || ! [ -x "$binary" ]; then
        echo "regression: $binary: no program" >&2
        exit 2
    fi
done
data=
if [ "${UVGRAFT_REGRESSION_REAL:-}" = 1 ]; then
    data=$(realpath -e "${UVGRAFT_DATA:?must name the folder with the real meshes}")
fi
keep=${UVGRAFT_REGRESSION_KEEP:-}
if [ -n "$keep" ]; then
    mkdir -p "$keep"
    keep=$(realpath "$keep")
fi

if [ $# = 1 ]; then
    hashes "$(realpath "$1")"
    exit
fi
status=0
for which in old new; do
    UVGRAFT_REGRESSION_KEEP=${keep:+$keep/$which} "$0" "$1" >"$temporary/$which" 2>"$temporary/$which.err" ||
        status=1
    cat "$temporary/$which.err" >&2
    shift
done
differences "$temporary/old" "$temporary/new" >"$temporary/differences"
cat "$temporary/differences"
if [ -s "$temporary/differences" ]; then status=1; fi
exit $status
