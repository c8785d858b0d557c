// The script of the grids, for which a page without a grid does not wait.
(function () {
    const grid = document.documentElement.dataset.grid;
    if (!grid) return;
    window.addEventListener('load', () => setTimeout(() => {
        const script = document.createElement('script');
        script.src = grid;
        document.head.append(script);
    }, 2000));
    // Until it is there, a link loads its page anew, with all scripts that this one needs.
    window.addEventListener('click', (event) => {
        if (!window.dash_ag_grid && event.target.closest('a[href]')) event.stopPropagation();
    }, true);
})();
