// Pictures after the text: numbers are read before plotly has drawn anything.
window.dash_clientside = Object.assign({}, window.dash_clientside, {
    pictures: {
        show: function (picture) {
            return new Promise((resolve) => requestAnimationFrame(() => setTimeout(() => resolve(picture), 100)));
        },
    },
});
