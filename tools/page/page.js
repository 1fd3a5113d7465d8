// What moves on a page of tools/page: tables that are sorted by a click, rows and marks on pictures that belong together,
// charts, and the pictures of a chart's point.
//
// For tests the root element says what came of it: data-charts-ready, how many charts are drawn with every point where
// it belongs; data-charts-failed, why one is not; data-point, which point's pictures are shown, and data-pictures, how
// many; data-pointed, how many rows and marks belong together under the mouse.
'use strict';

(() => {
const root = document.documentElement;

// ---- tables

function sort_key(cell) {
    const order = cell.dataset.order ?? cell.textContent;
    const number = Number.parseFloat(order);
    return Number.isNaN(number) ? order : number;
}

// Numbers stand before text, in both directions, so that what is missing comes last.
function compare(a, b, direction) {
    if (typeof a !== typeof b) return typeof a === 'number' ? -1 : 1;
    return direction * (typeof a === 'number' ? a - b : a.localeCompare(b));
}

function sort_by(head) {
    const direction = head.getAttribute('aria-sort') === 'ascending' ? -1 : 1;
    for (const other of head.parentElement.children) other.removeAttribute('aria-sort');
    head.setAttribute('aria-sort', direction > 0 ? 'ascending' : 'descending');
    const body = head.closest('table').tBodies[0];
    const rows = [...body.rows].map(row => ({row, key: sort_key(row.cells[head.cellIndex])}));
    rows.sort((a, b) => compare(a.key, b.key, direction));
    body.append(...rows.map(r => r.row));
}

for (const head of document.querySelectorAll('thead th')) head.addEventListener('click', () => sort_by(head));

// ---- rows and marks of one key

function keyed(key) { return document.querySelectorAll(`[data-key="${CSS.escape(key)}"]`); }
function key_at(event) { return event.target.closest?.('[data-key]') ?? null; }

// What belongs together is pointed out under the mouse.
function point_out(key) {
    for (const old of document.querySelectorAll('.pointed')) old.classList.remove('pointed');
    const all = key === undefined ? [] : keyed(key);
    for (const one of all) one.classList.add('pointed');
    root.dataset.pointed = all.length;
}

// A click on a row or a mark opens what is listed of it, and brings it into sight.
function lead_to(from) {
    for (const other of keyed(from.dataset.key)) {
        if (other === from || other instanceof SVGElement) continue;
        if (other instanceof HTMLDetailsElement) other.open = true;
        other.scrollIntoView({block: 'nearest'});
    }
}

if (document.querySelector('[data-key]')) {
    document.addEventListener('mouseover', event => point_out(key_at(event)?.dataset.key));
    document.addEventListener('click', event => {
        const from = key_at(event);
        if (from && !(from instanceof HTMLDetailsElement)) lead_to(from);
    });
}

const data_element = document.getElementById('data');
if (!data_element) return;
const data = JSON.parse(data_element.textContent);

// ---- axes

// The nearest of 1, 2, 5 and their decades that is not above the value, or not below it.
function round_number(value, up) {
    const decade = 10 ** Math.floor(Math.log10(value));
    const steps = [1, 2, 5, 10].map(s => s * decade);
    return up ? steps.find(s => s >= value * (1 - 1e-9)) : steps.findLast(s => s <= value * (1 + 1e-9));
}

const superscripts = '⁰¹²³⁴⁵⁶⁷⁸⁹';
function number_text(value) {
    const exponent = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
    if (value === 0 || (exponent >= -3 && exponent <= 4)) return String(Number.parseFloat(value.toPrecision(6)));
    const factor = Number.parseFloat((value / 10 ** exponent).toPrecision(3));
    const power = [...String(Math.abs(exponent))].map(d => superscripts[d]).join('');
    return (factor === 1 ? '' : factor + '·') + '10' + (exponent < 0 ? '⁻' : '') + power;
}

// Where a logarithmic axis begins and ends. With a 0 among the values its edge stands for 0.
function logarithmic_range(values) {
    const positive = values.filter(v => v > 0);
    if (positive.length === 0) positive.push(1);
    const least = Math.min(...positive), most = Math.max(...positive), zero = values.some(v => v === 0);
    return {min: round_number(least * (zero ? 0.45 : 0.9), false), max: round_number(most * 1.1, true), zero};
}

function logarithmic_ticks(range) {
    const first = Math.floor(Math.log10(range.min)), last = Math.ceil(Math.log10(range.max)), decades = last - first;
    const steps = decades <= 2 ? [1, 2, 5] : decades <= 3 ? [1, 3] : [1];
    const stride = Math.max(1, Math.ceil(decades / 9));
    const ticks = [];
    for (let decade = first; decade <= last; decade += stride)
        for (const step of steps) {
            const value = step * 10 ** decade;
            const on_edge = range.zero && value < range.min * 1.5;
            if (value >= range.min * 0.999 && value <= range.max * 1.001 && !on_edge) ticks.push({value});
        }
    if (range.zero) ticks.unshift({value: range.min});
    return ticks;
}

function axis(name, logarithmic, range) {
    if (!logarithmic) return {type: 'linear', title: {display: true, text: name}, grace: '5%'};
    return {
        type: 'logarithmic', min: range.min, max: range.max, title: {display: true, text: name},
        afterBuildTicks: scale => { scale.ticks = logarithmic_ticks(range); },
        ticks: {callback: value => range.zero && value === range.min ? '0' : number_text(value), autoSkip: false,
                maxRotation: 0},
    };
}

// ---- lines

// Told apart by colour and form, also by those who see fewer colours; the same name looks the same in every chart.
const colors = ['#0072b2', '#d55e00', '#009e73', '#b0579a', '#c58900', '#3a9fd6', '#7a5cc0', '#8a5a3c'];
const forms = ['circle', 'rect', 'triangle', 'rectRot', 'rectRounded', 'star', 'crossRot'];
const names = [];
for (const chart of data.charts)
    for (const line of chart.lines)
        if ((line.line === 'joined' || line.line === 'points') && !names.includes(line.name)) names.push(line.name);

const color_of = name => colors[names.indexOf(name) % colors.length];
const form_of = name => forms[names.indexOf(name) % forms.length];
const ink = name => getComputedStyle(root).getPropertyValue(name).trim();

let chosen = null;  // the id of the point whose pictures are shown

function shown_points(line) { return line.points.filter(p => p.x !== null && p.y !== null); }

function curve(line, place) {
    const points = shown_points(line), color = color_of(line.name);
    const at_zero = p => place.x(p.x) !== p.x || place.y(p.y) !== p.y;
    const is_chosen = p => p.id !== '' && p.id === chosen;
    return {
        label: line.name, points, data: points.map(p => ({x: place.x(p.x), y: place.y(p.y)})),
        showLine: line.line === 'joined', borderColor: color, borderWidth: 2,
        // Nobody can say how a line goes to 0 on a logarithmic axis.
        segment: {borderDash: c =>
            at_zero(points[c.p0DataIndex]) || at_zero(points[c.p1DataIndex]) ? [1, 5] : undefined},
        pointStyle: points.map(p => at_zero(p) ? 'triangle' : form_of(line.name)),
        pointRotation: points.map(p => at_zero(p) ? 180 : 0),
        pointRadius: c => points[c.dataIndex] && is_chosen(points[c.dataIndex]) ? 9 : 5,
        pointHoverRadius: 8, pointHitRadius: 6,
        pointBorderColor: c => points[c.dataIndex] && is_chosen(points[c.dataIndex]) ? ink('--text') : color,
        pointBorderWidth: 2, pointBackgroundColor: points.map(p => at_zero(p) ? ink('--page') : color), order: 1,
        clip: 12,  // points on the edge are whole
    };
}

// In steps: nothing lies on the way from one setting to the next.
function dashed(line, place) {
    const points = shown_points(line);
    return {
        label: line.name, points: [], data: points.map(p => ({x: place.x(p.x), y: place.y(p.y)})), showLine: true,
        stepped: true, borderColor: ink('--text'), borderWidth: 1.5, borderDash: [7, 4], pointStyle: 'line',
        pointRadius: 0, pointHitRadius: 0, pointHoverRadius: 0, order: 2,
    };
}

function level(line, place, across) {
    const height = line.points.length > 0 && line.points[0].y !== null ? place.y(line.points[0].y) : NaN;
    return {
        label: line.name, points: [], data: across.map(x => ({x, y: height})), showLine: true, fill: 'start',
        backgroundColor: ink('--soft'), borderColor: ink('--faint'), borderWidth: 1.5, borderDash: [2, 3],
        pointStyle: 'line', pointRadius: 0, pointHitRadius: 0, pointHoverRadius: 0, order: 3,
    };
}

function range_of(chart, key, logarithmic) {
    const values = [];
    for (const line of chart.lines)
        for (const point of line.line === 'level' ? line.points.slice(0, key === 'y' ? 1 : 0) : shown_points(line))
            if (point[key] !== null) values.push(point[key]);
    if (logarithmic) return logarithmic_range(values);
    return {min: Math.min(...values), max: Math.max(...values), zero: false};
}

function datasets(chart) {
    const x = range_of(chart, 'x', chart.log_x), y = range_of(chart, 'y', chart.log_y);
    const place = {
        x: v => chart.log_x && v === 0 ? x.min : v,
        y: v => chart.log_y && v === 0 ? y.min : v,
    };
    const make = {joined: curve, points: curve, dashed, level};
    return chart.lines.map(line => make[line.line](line, place, [x.min, x.max]));
}

// ---- pictures of a point

function image_source(picture) {
    const file = data.files[picture.file];
    return file ?? document.getElementById('file' + picture.file).src;
}

function element(name, text, parent) {
    const made = document.createElement(name);
    made.textContent = text;
    parent.append(made);
    return made;
}

function show_pictures(number, line, point) {
    for (const other of document.querySelectorAll('.chosen')) other.replaceChildren();
    const panel = document.querySelectorAll('.chosen')[number];
    element('h4', line.name, panel);
    const list = element('dl', '', panel);
    for (const [name, value] of point.values) {
        const pair = element('div', '', list);
        element('dt', name, pair);
        element('dd', value, pair);
    }
    const row = element('div', '', panel);
    row.className = 'pictures';
    const images = point.pictures.map(index => {
        const picture = data.pictures[index], figure = element('figure', '', row), image = element('img', '', figure);
        image.alt = picture.caption;
        image.src = image_source(picture);
        element('figcaption', picture.caption, figure);
        return image.decode();
    });
    Promise.all(images).then(() => { root.dataset.pictures = images.length; },
                             () => { root.dataset.pictures = 'broken'; });
}

function choose(number, line, point) {
    chosen = point.id === '' ? null : point.id;
    root.dataset.point = point.id;
    show_pictures(number, line, point);
    for (const drawn of charts) drawn.update('none');
}

function choose_by_link() {
    const id = decodeURIComponent(location.hash.slice(1));
    if (id === '' || id === chosen) return;
    for (const [number, chart] of data.charts.entries())
        for (const line of chart.lines)
            for (const point of line.points)
                if (point.id === id) {
                    choose(number, line, point);
                    document.querySelectorAll('section.chart')[number].scrollIntoView();
                    return;
                }
}

// ---- charts

function options(chart, number) {
    const point_at = item => item.chart.data.datasets[item.datasetIndex].points[item.dataIndex ?? item.index];
    return {
        responsive: true, maintainAspectRatio: false, animation: false, parsing: false, normalized: false,
        interaction: {mode: 'nearest', intersect: true},
        scales: {x: axis(chart.x, chart.log_x, range_of(chart, 'x', chart.log_x)),
                 y: axis(chart.y, chart.log_y, range_of(chart, 'y', chart.log_y))},
        plugins: {
            legend: {position: 'top', align: 'start', labels: {
                usePointStyle: true, boxWidth: 8, boxHeight: 8, padding: 16,
                sort: (a, b) => a.datasetIndex - b.datasetIndex}},
            tooltip: {
                displayColors: false, padding: 10, filter: item => point_at(item) !== undefined,
                callbacks: {title: items => items.length > 0 ? items[0].dataset.label : '',
                            label: item => point_at(item).values.map(([name, value]) => name + ': ' + value)},
            },
        },
        onHover: (event, items) => { event.native.target.style.cursor = items.length > 0 ? 'pointer' : 'default'; },
        onClick: (event, items, drawn) => {
            if (items.length === 0) return;
            const {datasetIndex, index} = items[0], point = drawn.data.datasets[datasetIndex].points[index];
            if (point === undefined) return;
            choose(number, chart.lines[datasetIndex], point);
            if (point.id !== '') history.replaceState(null, '', '#' + encodeURIComponent(point.id));
        },
    };
}

// Axes, legend and lines in the inks of the page as it is now: light, dark or printed.
function color(drawn) {
    drawn.data.datasets = datasets(data.charts[drawn.number]);
    drawn.data.datasets.forEach((made, i) => { made.hidden = !drawn.isDatasetVisible(i); });
    for (const scale of Object.values(drawn.options.scales)) {
        scale.ticks.color = scale.title.color = ink('--text');
        scale.grid.color = scale.grid.borderColor = ink('--line');
    }
    drawn.options.plugins.legend.labels.color = ink('--text');
    drawn.update('none');
}

const charts = [];

// Every point is drawn, within the axes.
function fault(drawn) {
    if (!(drawn.width > 0 && drawn.height > 0)) return 'has no size';
    const area = drawn.chartArea, lines = data.charts[drawn.number].lines;
    for (const [i, line] of lines.entries()) {
        const expected = line.line === 'level' ? 2 : shown_points(line).length, points = drawn.getDatasetMeta(i).data;
        if (points.length !== expected) return line.name + ': ' + points.length + ' points of ' + expected;
        if (line.line === 'level') continue;
        for (const p of points)
            if (!(p.x >= area.left - 1 && p.x <= area.right + 1 && p.y >= area.top - 1 && p.y <= area.bottom + 1))
                return line.name + ': a point outside the axes';
    }
    return null;
}

function draw_all() {
    Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
    Chart.defaults.font.size = 13;
    for (const [number, canvas] of document.querySelectorAll('canvas[data-chart]').entries()) {
        const chart = data.charts[number];
        const drawn = new Chart(canvas, {
            type: 'scatter', data: {datasets: datasets(chart)}, options: options(chart, number),
        });
        drawn.number = number;
        charts.push(drawn);
        color(drawn);
    }
    choose_by_link();
    const faults = charts.map(fault);
    root.dataset.chartsReady = faults.filter(f => f === null).length;
    const failed = faults.findIndex(f => f !== null);
    if (failed >= 0) root.dataset.chartsFailed = data.charts[failed].title + ': ' + faults[failed];
}

window.addEventListener('hashchange', choose_by_link);
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => charts.forEach(color));
for (const [event, printing] of [['beforeprint', true], ['afterprint', false]])
    window.addEventListener(event, () => {
        root.classList.toggle('printing', printing);
        charts.forEach(drawn => { drawn.resize(); color(drawn); });
    });
try {
    draw_all();
} catch (error) {
    root.dataset.chartsFailed = String(error);
    throw error;
}
})();
