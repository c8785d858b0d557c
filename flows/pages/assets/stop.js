// The press of a Stop button. The page is renewed every other second, and a click is lost where its
// button is put in anew between press and release: here the place counts, and not the element.
(function () {
    let pressed = null;

    function stopAt(event) {
        const found = document.elementFromPoint(event.clientX, event.clientY);
        return found && found.closest('[data-stop]');
    }

    function cookie(name) {
        const found = document.cookie.split('; ').find((each) => each.startsWith(name + '='));
        return found ? decodeURIComponent(found.slice(name.length + 1)) : '';
    }

    function tell(sentence) {
        const shown = document.createElement('div');
        shown.className = 'not-stopped';
        shown.textContent = sentence;
        shown.addEventListener('click', () => shown.remove());
        document.body.append(shown);
    }

    async function stop(button) {
        const {stop: station, failed} = button.dataset;
        button.classList.add('is-pressed');
        try {
            const answer = await fetch('/api/v1/stop', {
                method: 'POST',
                headers: {'Content-Type': 'application/json', 'X-CSRFToken': cookie('_csrf_token')},
                body: JSON.stringify({station}),
            });
            const became = await answer.json();
            if (!answer.ok) tell(`${failed} ${station}: ${became.error}`);
        } catch (fault) {
            tell(`${failed} ${station}: ${fault.message}`);
        } finally {
            button.classList.remove('is-pressed');
        }
    }

    window.addEventListener('pointerdown', (event) => {
        const button = event.isPrimary && event.button === 0 && stopAt(event);
        pressed = button ? button.dataset.stop : null;
    }, true);
    window.addEventListener('pointercancel', () => { pressed = null; }, true);
    window.addEventListener('pointerup', (event) => {
        const button = stopAt(event);
        if (button && button.dataset.stop === pressed) stop(button);
        pressed = null;
    }, true);
    window.addEventListener('click', (event) => {
        const button = event.target.closest('[data-stop]');
        if (button && event.detail === 0) stop(button); // by the keyboard, or by what reads aloud
    }, true);
})();
