// The choices of a page: each is a part of the address, which the server answers.
(function () {
    // The address of what is chosen now; nothing where it is what was asked, as when the page comes.
    // resets: what is asked anew where another choice came before it.
    function address(names, values, resets) {
        const asked = values[names.length], same = window.dash_clientside.no_update;
        if (!asked) return same;
        const chosen = Object.fromEntries(names.map((name, place) => [name, values[place] || '']));
        if (names.every((name) => chosen[name] === (asked[name] || ''))) return same;
        for (const [name, others] of Object.entries(resets)) {
            if (chosen[name] !== (asked[name] || '')) for (const other of others) chosen[other] = '';
        }
        const given = Object.entries(chosen).filter(([, value]) => value);
        return '?' + new URLSearchParams(given).toString();
    }
    window.dash_clientside = Object.assign({}, window.dash_clientside, {
        choices: {
            quality: function (...values) {
                const names = ['model', 'item', 'element', 'station', 'serial', 'since', 'until', 'plot'];
                return address(names, values, {model: ['item', 'element', 'serial'], item: ['element']});
            },
            mismatch: function (...values) {
                return address(['effect', 'station', 'model', 'serial'], values, {model: ['serial']});
            },
            open: function (click) {
                const run = click && click.points[0].customdata;
                if (!run) return window.dash_clientside.no_update;
                return `/run?id=${encodeURIComponent(run)}`;
            },
        },
    });
})();
