// A control of a page writes what it asks for into the address, which the server answers.
window.dash_clientside = Object.assign({}, window.dash_clientside, {
    asked: {
        ask: function (values, ids, search) {
            const asked = new URLSearchParams(search);
            const of = {model: ['item', 'element', 'serial'], item: ['element']}; // what another one has not
            let changed = false;
            ids.forEach((id, i) => {
                const value = String(values[i] ?? '');
                if (value === id.was) return;
                changed = true;
                (of[id.asks] || []).forEach((name) => asked.delete(name));
                if (value) asked.set(id.asks, value);
                else asked.delete(id.asks);
            });
            return changed ? '?' + asked.toString() : window.dash_clientside.no_update;
        },
    },
});
