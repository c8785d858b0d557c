// The press of a Stop, Release or Acknowledge button. The page is renewed every other second, and a click is lost where its
// button is put in anew between press and release: here the place counts, and not the element.
(function () {
    let pressed = null;

    const BUTTONS = '[data-stop], [data-release], [data-acknowledge]';

    function buttonAt(event) {
        const found = document.elementFromPoint(event.clientX, event.clientY);
        return found && found.closest(BUTTONS);
    }

    function named(button) {
        const {stop, release, acknowledge} = button.dataset;
        return [stop, release, acknowledge].join();
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

    async function press(button) {
        const {stop, release, acknowledge, failed, ask} = button.dataset;
        const station = stop || release || '';
        const action = stop ? 'stop' : release ? 'release' : 'acknowledge';
        if (ask && !await window.asking(button.dataset)) return;
        button.classList.add('is-pressed');
        try {
            const answer = await fetch(`/api/v1/${action}`, {
                method: 'POST',
                headers: {'Content-Type': 'application/json', 'X-CSRFToken': cookie('_csrf_token')},
                body: JSON.stringify(acknowledge ? {alarm: acknowledge} : {station}),
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
        const button = event.isPrimary && event.button === 0 && buttonAt(event);
        pressed = button ? named(button) : null;
    }, true);
    window.addEventListener('pointercancel', () => { pressed = null; }, true);
    window.addEventListener('pointerup', (event) => {
        const button = buttonAt(event);
        if (button && named(button) === pressed) press(button);
        pressed = null;
    }, true);
    window.addEventListener('click', (event) => {
        const button = event.target.closest(BUTTONS);
        if (button && event.detail === 0) press(button); // by the keyboard, or by what reads aloud
    }, true);
})();
