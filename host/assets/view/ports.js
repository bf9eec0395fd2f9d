// The serial ports of this computer, and a button that shows the board at one.
import { post } from "./settings.js";
import { json } from "./runs.js";

const $ = (id) => document.getElementById(id);

function say(text, isWrong = false) {
  $("ports-message").textContent = text;
  $("ports-message").classList.toggle("alarm", isWrong);
}

// `changed` is called when a board was connected.
export function begin(changed) {
  const connect = async (name) => {
    say(`Connecting ${name}.`);
    try {
      await post(`/connect?${new URLSearchParams({ port: name })}`, "");
      say("");
      await changed();
    } catch (error) {
      say(error.message, true);
    }
    await list();
  };
  const row = ({ name, usb, used_by: users }) => {
    const item = document.createElement("li");
    const about = [usb?.product, usb?.serial_number && `serial number ${usb.serial_number}`, users.length && `in use by ${users.join(", ")}`];
    const text = Object.assign(document.createElement("span"), { textContent: [name, ...about.filter(Boolean)].join(", ") });
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Connect" });
    button.setAttribute("aria-label", `Connect ${name}`);
    button.addEventListener("click", () => connect(name));
    item.append(text, button);
    return item;
  };
  async function list() {
    const found = await json("/ports").catch((error) => error);
    if (found instanceof Error) say(found.message, true);
    $("port-rows").replaceChildren(...(found instanceof Error ? [] : found.map(row)));
    if (!(found instanceof Error) && found.length === 0) say("This computer has no serial port: plug a board in, and list again.");
  }
  $("ports-list").addEventListener("click", () => {
    say("");
    list();
  });
  list();
}
