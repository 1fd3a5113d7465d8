#!/bin/bash
# Opens a page of tools/page in a headless Chromium: every chart is drawn with its points in their places, a link and a
# click show a point's pictures, the mouse its values, a click on a head sorts, a mark on a picture points to its list. Without Chromium: skipped (status 77).
# To run it: apt-get install chromium, then ctest -R page_in_browser.
# Usage: page_in_browser.sh <folder of the build> <test_tools>
set -euo pipefail
page=$1/page_in_browser.html
work=$1/page_in_browser
command -v chromium > /dev/null || { echo "page_in_browser: skipped: no chromium"; exit 77; }
rm -rf "$work" "$page"
mkdir -p "$work"
"$2" "[page_file]" > "$work/log" || { cat "$work/log"; exit 1; }

# look <name> <link>: the page after all its scripts, in $work/<name>.html.
look() {
    timeout 120 chromium --headless --no-sandbox --disable-gpu --user-data-dir="$work/profile" \
        --virtual-time-budget=4000 --dump-dom "file://$2" > "$work/$1.html" 2> "$work/log" ||
        { cat "$work/log"; echo "page_in_browser: $1: chromium failed"; exit 1; }
}
# expect <name> <text>: of the root element, where the page's script says what came of it.
expect() {
    local root
    root=$(grep -m1 -o '<html[^>]*>' "$work/$1.html") || root="no page"
    [[ $root == *"$2"* ]] || { echo "page_in_browser: $1: expected $2 in $root"; exit 1; }
}

look drawn "$page"
expect drawn 'data-charts-ready="3"'
! grep -m1 '<html[^>]*data-charts-failed' "$work/drawn.html" || { echo "page_in_browser: a chart is not drawn"; exit 1; }

look linked "$page#point=0"
expect linked 'data-point="point=0"'
expect linked 'data-pictures="3"'

# The same page with a visitor in it, who moves and clicks.
visitor='<script>
const root = document.documentElement, canvas = document.querySelector("canvas"), chart = Chart.getChart(canvas);
const send = type => {
    const place = chart.getDatasetMeta(0).data[0], box = canvas.getBoundingClientRect();
    canvas.dispatchEvent(
        new MouseEvent(type, {clientX: box.left + place.x, clientY: box.top + place.y, bubbles: true}));
};
const column = number => [...document.querySelectorAll("tbody tr")].map(r => r.cells[number].textContent).join();
const head = document.querySelectorAll("thead th button")[1];
head.click();
root.dataset.ascending = column(1);
head.click();
root.dataset.descending = column(1);
const mark = document.querySelector("circle[data-key]"), list = document.querySelector("details[data-key]");
mark.dispatchEvent(new MouseEvent("mouseover", {bubbles: true}));
root.dataset.marked = root.dataset.pointed + list.classList.contains("pointed") + list.open;
mark.dispatchEvent(new MouseEvent("click", {bubbles: true}));
root.dataset.opened = list.open;
canvas.dispatchEvent(new MouseEvent("mouseover", {bubbles: true}));
root.dataset.left = document.querySelectorAll(".pointed").length;
send("mousemove");
setTimeout(() => {
    root.dataset.tooltip = chart.tooltip.body.map(b => b.lines.join()).join().slice(0, 9);
    send("click");
}, 300);
</script>'
# Without a screen there may be no next frame, which events wait for.
frames='<script>window.requestAnimationFrame = f => setTimeout(f, 16);</script>'
{ sed "s#</body></html>##; s#<h1>#$frames&#" "$page"; echo "$visitor</body></html>"; } > "$work/visited_page.html"
look visited "$work/visited_page.html"
expect visited 'data-tooltip="settings:"'
expect visited 'data-point="point=0"'
expect visited 'data-pictures="3"'
expect visited 'data-marked="2truefalse"'
expect visited 'data-opened="true"'
expect visited 'data-left="0"'
expect visited 'data-ascending="9,10,undefined"'
expect visited 'data-descending="10,9,undefined"'
echo "page_in_browser: charts, links, clicks and tables work"
