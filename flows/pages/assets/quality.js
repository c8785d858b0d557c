// A point of the control chart opens its run.
window.dash_clientside = Object.assign({}, window.dash_clientside, {
    quality: {
        open: function (click) {
            const run = click && click.points[0].customdata;
            if (!run) return window.dash_clientside.no_update;
            return `/run?id=${encodeURIComponent(run)}`;
        },
    },
});
