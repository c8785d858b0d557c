// How the grids show what is more than text. React escapes every value.
window.dashAgGridComponentFunctions = Object.assign(window.dashAgGridComponentFunctions || {}, {
    State: function (cell) {
        if (!cell.data) return null;
        const kind = cell.data[`${cell.colDef.field}_kind`];
        return React.createElement('span', {className: `state state-${kind}`}, cell.value);
    },
    UnitLink: function (cell) {
        if (!cell.data) return null;
        const href = `/unit?id=${encodeURIComponent(cell.data.unit)}`;
        return React.createElement(window.dash_core_components.Link, {href}, cell.value);
    },
    RunLink: function (cell) {
        if (!cell.data) return null;
        const href = `/run?id=${encodeURIComponent(cell.value)}`;
        return React.createElement(window.dash_core_components.Link, {href}, cell.value);
    },
});
