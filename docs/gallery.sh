#!/usr/bin/env bash
# Makes docs/gallery.md and its pictures: runs a scene for every figure of both papers, and draws one frame of each.
#
#     docs/gallery.sh                  all; about half an hour on two cores
#     docs/gallery.sh fig17 lattice    those whose names begin with one of these words; the page is made of all that were ever run
#
# Runs stay in runs/gallery; one that is there is not run again.
set -euo pipefail
cd "$(dirname "$0")/.."

# name | figure | what is seen | scene | frame, or - for the last | keys that are set
figures='
fig01a|Chen et al., 1a|Glass, hit by a ball|fig01a_glass|-|
fig01b|Chen et al., 1b and 6|Glass with a weak direction|fig01b_glass|-|
fig01c|Chen et al., 1c|A plastic wall, hit by a ball|fig01c_plastic|-|
fig01d|Chen et al., 1d|A plastic wall with a weak direction|fig01d_plastic|-|
fig03|Chen et al., 3|A figure, drawn back and let go|fig03_armadillo|20|
fig04|Chen et al., 4|An elastic and a plastic wall after the blow|fig04_walls|-|
fig05a|Chen et al., 5|It may flow by γ = 0.1|fig05_gamma|-|body.wall.material.plastic_cap=0.1
fig05b|Chen et al., 5|The same with γ = 0.2|fig05_gamma|-|body.wall.material.plastic_cap=0.2
fig07|Chen et al., 7|Glass that weakens as it breaks, α = 2: less dust|fig01a_glass|-|body.wall.fracture.alpha=2
fig08|Chen et al., 8|A bullet has gone through jello|fig08_jello|-|
fig09|Chen et al., 9|Bars of ν = 0.1, 0.2, 0.3, 0.45, stretched|fig09_stretch|-|
fig10|Chen et al., 10|A soft and a stiff beam, bent by their weight|fig10_bend|-|
fig11|Chen et al., 11|A beam swings|fig11_swing|45|
fig12|Chen et al., 12|A bar, twisted by half a turn|fig12_twist|-|
fig13|Chen et al., 13|A pawn vibrates|fig13_stand_in|23|
fig14|Chen et al., 14 and 18|A figure is torn apart|fig14_torn|28|
fig15|Chen et al., 15|Glass that is pressed: cracked, and in one piece|fig15_pressed|-|
fig16|Chen et al., 16|A soft figure falls and breaks|bunny|-|body.bunny.mesh=assets/figure.ply
fig17|Chen et al., 17|A sheet with cuts is torn|fig17_sheet|-|
lattice_fig04|Ohta et al., 4|A sphere is broken open: faces bent by noise|lattice/sphere|-|
lattice_fig05|Ohta et al., 5|A rod tears, its nodes merge again|lattice/merging|-|
lattice_fig06|Ohta et al., 6|A soft glob is dropped|lattice/dropped|-|
lattice_fig07a|Ohta et al., 7 a–c|A figure is torn by its weight|lattice/hung|24|
lattice_fig07d|Ohta et al., 7 d–i|15 figures fall on a ball|lattice/elephants_15|45|
vase|ours|A vase shatters|vase|-|
inclusion|ours|A crack runs around a disc that is glued in weakly|inclusion|-|
'

cargo build --release --quiet -p fissure-cli
fissure=target/release/fissure
mkdir -p docs/gallery runs/gallery

wanted() {
    [ $# -gt 1 ] || return 0
    local name=$1 word
    shift
    for word in "$@"; do [[ $name == "$word"* ]] && return 0; done
    return 1
}

while IFS='|' read -r name _ _ scene frame keys; do
    [ -n "$name" ] && wanted "$name" "$@" || continue
    run=runs/gallery/$name
    if [ ! -f "$run/last.png" ]; then
        rm -rf "$run"
        set=()
        for key in $keys; do set+=(--set "$key"); done
        echo "$name: scenes/$scene.toml"
        "$fissure" run "scenes/$scene.toml" --out "$run" --quiet "${set[@]}" || { echo "$name failed"; continue; }
    fi
    choose=()
    [ "$frame" = - ] || choose=(--frame "$frame")
    "$fissure" render "$run" "${choose[@]}" --size 480x270 --out "docs/gallery/$name.png" >/dev/null
done <<<"$figures"

{
    echo "# Gallery"
    echo
    echo "Every figure of the two papers that Fissure builds on, in our own rendering, from the scenes in \`scenes\`: made by"
    echo "\`docs/gallery.sh\`. What must be seen in each, and what tests ask of it, is in [scenes.md](scenes.md). Times are those of the whole run"
    echo "on $(nproc) cores ($(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)), which had other work to do as well."
    echo
    echo "| | figure | what is seen | particles at the start | steps | time |"
    echo "|---|---|---|---|---|---|"
    while IFS='|' read -r name figure seen scene _ _; do
        log=runs/gallery/$name/run.log
        [ -n "$name" ] && [ -f "$log" ] && [ -f "docs/gallery/$name.png" ] || continue
        particles=$(sed -n '2s/.*/&/p' "runs/gallery/$name/series.csv" | cut -d, -f7)
        done=$(sed -n 's/^\([0-9]* steps\) in \([0-9.]* s\),.*/\1|\2/p' "$log" | tail -1)
        echo "| ![$seen](gallery/$name.png) | $figure | [$seen](../scenes/$scene.toml) | $particles | ${done%|*} | ${done#*|} |"
    done <<<"$figures"
} >docs/gallery.md
echo "docs/gallery.md"
