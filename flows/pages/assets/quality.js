// The choices of the quality page: each is a part of the address, which the server answers.
window.dash_clientside = Object.assign({}, window.dash_clientside, {
    quality: {
        ask: function (model, item, element, station, serial, since, until, plot, asked) {
            const chosen = {model, item, element, station, serial, since, until, plot};
            const empty = window.dash_clientside.no_update;
            if (!asked) return empty;
            const same = Object.keys(chosen).every((name) => (chosen[name] || '') === (asked[name] || ''));
            if (same) return empty;
            if (chosen.model !== asked.model) Object.assign(chosen, {item: '', element: '', serial: ''});
            if (chosen.item !== asked.item) chosen.element = '';
            const given = Object.entries(chosen).filter(([, value]) => value);
            return '?' + new URLSearchParams(given).toString();
        },
        open: function (click) {
            const run = click && click.points[0].customdata;
            if (!run) return window.dash_clientside.no_update;
            return `/run?id=${encodeURIComponent(run)}`;
        },
    },
});
