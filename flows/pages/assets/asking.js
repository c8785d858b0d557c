// A question before what cannot be taken back: data-ask, data-yes and data-no of a button. It stands outside of the
// page, which is renewed meanwhile, and locks nothing: Stop can be pressed under it.
window.asking = function ({ask, yes, no}) {
    document.querySelectorAll('.asking').forEach((earlier) => earlier.answer(false));
    return new Promise((resolve) => {
        const bar = document.createElement('div');
        bar.className = 'asking';
        bar.setAttribute('role', 'alertdialog');
        bar.setAttribute('aria-label', ask);
        bar.append(ask);
        bar.answer = (agreed) => {
            bar.remove();
            resolve(agreed);
        };
        for (const [word, agreed] of [[yes, true], [no, false]]) {
            const button = document.createElement('button');
            button.textContent = word;
            button.className = agreed ? 'yes' : 'no';
            button.addEventListener('click', () => bar.answer(agreed));
            bar.append(button);
        }
        document.body.append(bar);
        bar.lastChild.focus();
    });
};
(function () {
    let agreed = null;
    window.addEventListener('click', async (event) => {
        const button = event.target.closest('[data-ask]:not([data-release])');
        if (!button || button === agreed) return;
        event.stopPropagation();
        event.preventDefault();
        if (!await window.asking(button.dataset)) return;
        agreed = document.getElementById(button.id) || button;
        agreed.click();
        agreed = null;
    }, true);
})();
